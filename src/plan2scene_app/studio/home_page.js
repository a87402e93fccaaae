// The page with the list of all projects (homes).

import { el } from "./dom.js";

const STATES = { none: "no house yet", running: "being made\u2026", done: "house ready", failed: "the last run failed", cancelled: "run cancelled", interrupted: "run interrupted" };
const { projects, folder } = JSON.parse(document.getElementById("start").textContent);
const nothing = el("li", { className: "soft" }, "No home yet: give one a name.");

document.getElementById("projects").append(...(projects.length ? projects.map(({ name, title, state, preview }) =>
  el("li", {}, el("a", { href: `p/${name}/` }, preview ? el("img", { src: `p/${name}/results/preview.png`, alt: "" }) : el("div", { className: "blank" }, "plan"), el("strong", {}, title), el("span", {}, STATES[state])))) : [nothing]));
document.getElementById("folder").textContent = `Homes are folders in ${folder}. The studio serves this machine alone: copy photos of a phone here first.`;
document.getElementById("new").addEventListener("submit", async (event) => {
  event.preventDefault();
  const name = event.target.elements.name.value.trim();
  const answer = await fetch("projects", { method: "POST", body: JSON.stringify({ name }) });
  const found = await answer.json();
  if (answer.ok) location.href = `p/${found.name}/`;
  else document.getElementById("status").textContent = found.error;
});
document.body.dataset.ready = "true";
