// The host of a page without a server: plans and tables are opened from files and saved as downloads.

import { planText, tableText } from "./document.js";
import { ask, download, el } from "./dom.js";

const DELAY = 800; // milliseconds from a change until the draft is stored

/** Key of unsaved changes in the browser's storage: a hash of the data with which the page began. */
async function draftName(start) {
  const bytes = new TextEncoder().encode(JSON.stringify([start.house, start.plan, start.picture?.url?.length]));
  const digest = await crypto.subtle?.digest("SHA-256", bytes);
  return digest && `plan2scene ${[...new Uint8Array(digest)].slice(0, 10).map((v) => v.toString(16).padStart(2, "0")).join("")}`;
}

export class Files {
  #name = null; #timer = 0;

  /** Store unsaved changes in the browser, and offer to restore those of an earlier visit. */
  async keepDrafts(app, start) {
    try { this.#name = await draftName(start); } catch { return; }
    const left = this.#name && localStorage.getItem(this.#name);
    if (!left || app.store.canUndo) return;
    const { plan, photos, picture } = JSON.parse(left);
    const again = await ask("There is a drawing that was not saved", [el("p", {}, `${plan.rooms.length} rooms, drawn in this page before it was closed.`)], "Go on with it");
    if (again) app.store.changeWhole({ plan, photos, picture: app.picture ? picture : null });
    else localStorage.removeItem(this.#name);
    app.fit();
  }
  /** Called at every change of the document. */
  changed(app) {
    if (!this.#name) return;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      try {
        if (app.store.unsaved) localStorage.setItem(this.#name, JSON.stringify(app.store.state));
        else localStorage.removeItem(this.#name);
      } catch { /* storage is full or not allowed */ }
    }, DELAY);
  }

  /** Save the plan and, if there are photos, the photo table. */
  async save(app) {
    const { plan, photos } = app.store.state;
    if (!plan.rooms.length) { app.say("Nothing to save yet: draw a room first"); return; }
    const errors = app.problems.filter((problem) => problem.level === "error");
    if (errors.length && !(await ask(`${errors.length} problem${errors.length > 1 ? "s" : ""} would stop a run`, [el("p", {}, `expected ${errors[0].expected}, found ${errors[0].found}`)], "Save anyway"))) return;
    download("plan.json", planText(plan), "application/json");
    if (photos.length) download("photos.csv", tableText(photos), "text/csv");
    app.store.markSaved();
    app.say(`Saved. Next: plan2scene run --plan plan.json${photos.length ? " --photos photos.csv --photos-dir FOLDER_OF_PHOTOS" : ""} --out ${app.house || "my_house"}`);
  }
  async openOther(file) {
    throw new Error(`this page opens plan.json, photos.csv and pictures; other plans: plan2scene edit ${file.name} --out editor.html`);
  }
}
