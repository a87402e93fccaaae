import { Files } from "./files.js";
import { startEditor } from "./start.js";

const begun = JSON.parse(document.getElementById("start").textContent), files = new Files();
files.keepDrafts(startEditor(begun, files), begun);
