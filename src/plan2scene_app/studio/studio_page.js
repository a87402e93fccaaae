// The page of one project: the editor on one tab, the house on the other.

import { HouseView } from "./house_view.js";
import { editorState, photoUrl, Server } from "./server.js";
import { startEditor } from "./start.js";

const parsed = (id) => JSON.parse(document.getElementById(id).textContent);
const found = parsed("start"), host = new Server(found.revision, found.source);
const state = editorState(found, parsed("rules"));
const app = startEditor({ house: found.house, plan: state.plan, photos: state.photos, notes: found.notes }, host);
for (const { name } of found.photos) app.thumbs.set(name, photoUrl(name));
if (found.place) {
  const image = new Image();
  image.onload = () => {
    app.picture = { url: image.src, width: image.naturalWidth, height: image.naturalHeight };
    host.take({ ...found, revision: host.revision });
    app.fit();
  };
  image.src = "picture";
} else app.changed();

const tabs = { plan: document.getElementById("tab-plan"), house: document.getElementById("tab-house") };
function showTab(name) {
  for (const [key, tab] of Object.entries(tabs)) tab.setAttribute("aria-selected", String(key === name));
  document.getElementById("house").hidden = name !== "house";
  for (const id of ["tools", "panel"]) document.getElementById(id).hidden = name === "house";
  document.querySelector("main").hidden = name === "house";
  document.body.classList.toggle("in-house", name === "house");
  history.replaceState(null, "", name === "house" ? "#house" : "#");
  if (name === "plan") app.render();
}
for (const [name, tab] of Object.entries(tabs)) tab.addEventListener("click", () => showTab(name));
document.addEventListener("visibilitychange", () => { if (document.hidden) host.flush(); });
globalThis.house = new HouseView(app, host, app.rules);
if (location.hash === "#house") showTab("house"); // the tab before a reload
