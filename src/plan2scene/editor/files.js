// The page alone: plans and tables are saved as downloads and opened from files.

import { planText, tableText } from "./document.js";
import { ask, download, el } from "./dom.js";

export class Files {
  /** Save the plan, and the photo table where there are photos. */
  async save(app) {
    const { plan, photos } = app.store.state;
    if (!plan.rooms.length) { app.say("Nothing to save yet: draw a room first"); return; }
    const errors = app.problems.filter((problem) => problem.level === "error");
    if (errors.length && !(await ask(`${errors.length} problem${errors.length > 1 ? "s" : ""} would stop a run`, [el("p", {}, `expected ${errors[0].expected}, found ${errors[0].found}`)], "Save anyway"))) return;
    download("plan.json", planText(plan), "application/json");
    if (photos.some((photo) => photo.rooms.length)) download("photos.csv", tableText(photos), "text/csv");
    app.store.markSaved();
    app.say(`Saved. Next: plan2scene run --plan plan.json${photos.length ? " --photos photos.csv --photos-dir FOLDER_OF_PHOTOS" : ""} --out ${app.house || "my_house"}`);
  }
  async openOther(file) {
    throw new Error(`this page opens plan.json, photos.csv and pictures; other plans: plan2scene edit ${file.name} --out editor.html`);
  }
}
