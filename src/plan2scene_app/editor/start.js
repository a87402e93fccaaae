// Starts the editor with the data that Python wrote into the page.

import { App } from "./app.js";
import { takeFiles } from "./photos.js";
import { isZip } from "./zip.js";

const byId = (id) => document.getElementById(id);
const json = (id) => JSON.parse(byId(id).textContent);

/** Make the editor in the page; `host` loads and saves files. */
export function startEditor(start, host) {
  const page = { svg: byId("drawing"), panel: byId("panel"), tools: byId("tools"), status: byId("status"), undo: byId("undo"), redo: byId("redo"), saved: byId("saved") };
  const app = new App(json("rules"), start, host, page);
  page.undo.addEventListener("click", () => app.store.undo());
  page.redo.addEventListener("click", () => app.store.redo());
  byId("save").addEventListener("click", () => host.save(app));
  byId("open").addEventListener("click", () => app.pickFile("", (files) => (files.length === 1 && !isZip(files[0]) ? app.openFile(files[0]) : takeFiles(app, files)), true));
  byId("fit").addEventListener("click", () => app.fit());
  byId("help").addEventListener("click", () => byId("keys").showModal());
  byId("feet").addEventListener("change", (event) => { app.feet = event.target.value === "feet"; app.changed(); });
  document.body.dataset.ready = "true";
  globalThis.editor = app;
  return app;
}
