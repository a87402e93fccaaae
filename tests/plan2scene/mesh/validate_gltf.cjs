// Prints the Khronos validator's report of each GLB as one JSON list.
// The package gltf-validator is found through GLTF_VALIDATOR_DIR (a folder with node_modules),
// else as Node finds packages (NODE_PATH, node_modules of a parent folder).
"use strict";
const fs = require("fs");
const folder = process.env.GLTF_VALIDATOR_DIR;
const options = folder ? { paths: [folder] } : { paths: require.resolve.paths("gltf-validator") };
const validator = require(require.resolve("gltf-validator", options));

async function main() {
  const reports = [];
  for (const file of process.argv.slice(2)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    reports.push({ file, ...report.issues });
  }
  console.log(JSON.stringify(reports));
}

main().catch((error) => { console.error(error); process.exit(1); });
