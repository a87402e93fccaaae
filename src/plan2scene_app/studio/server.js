// The editor's host in the studio: it saves every change on the server and takes changes of other tabs.

import { completed } from "./app.js";
import { newPlan, roomCalled } from "./document.js";
import { ask, button, el } from "./dom.js";
import { askReading } from "./reading.js";

const DELAY = 400; // milliseconds from a change to its saving

/** Send a request to the server; a refusal throws an error with the server's message. */
export async function asked(path, options = {}) {
  let answer;
  try { answer = await fetch(path, options); } catch { throw new Error("the studio does not answer: is it still running?"); }
  if (answer.ok) return answer.json();
  const text = await answer.text();
  let line = text.trim(), reading;
  try { ({ error: line, reading } = JSON.parse(text)); } catch { /* plain text */ }
  throw Object.assign(new Error(line), { status: answer.status, reading });
}

export const photoUrl = (name) => `photos/${encodeURIComponent(name)}`;

/** The editor's state made from the server's. */
export function editorState(found, rules) {
  const plan = found.plan ? completed(found.plan, rules) : newPlan(rules);
  const photos = found.photos.map(({ name, rooms }) => ({ name, rooms: rooms.map((room) => roomCalled(plan.rooms, room)) }));
  return { plan, photos, picture: found.place };
}

export class Server {
  #timer = 0; #kept = null; #notes = null; #saving = false;

  constructor(revision, source) { Object.assign(this, { revision, source }); }

  /** Called at every change of the document. */
  changed(app) {
    this.app = app;
    const { state } = app.store;
    this.#kept ??= state;
    this.#notes ??= app.notes;
    if (!this.#unsaved) return;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.flush(), DELAY);
  }
  get #unsaved() { return this.app.store.state !== this.#kept || this.app.notes !== this.#notes; }
  get pending() { return this.#saving || this.#unsaved; }

  /** Save unsaved changes; resolves when they are saved. */
  async flush() {
    clearTimeout(this.#timer);
    if (this.#saving) { this.#timer = setTimeout(() => this.flush(), DELAY); return; }
    if (!this.#unsaved) return;
    const { store, notes } = this.app, { state } = store;
    this.#saving = true;
    try {
      const body = JSON.stringify({ plan: state.plan, photos: state.photos, place: state.picture, notes, revision: this.revision });
      ({ revision: this.revision } = await asked("state", { method: "PUT", body }));
      this.#kept = state;
      this.#notes = notes;
      store.markSaved(state);
      this.app.page.saved.textContent = store.unsaved ? "not saved" : "saved";
    } catch (error) {
      if (error.status === 409) await this.conflict();
      else { this.app.say(`Not saved: ${error.message}`); this.#timer = setTimeout(() => this.flush(), 3000); }
    } finally { this.#saving = false; }
  }
  async save() { await this.flush(); this.app.say("Saved"); }

  async conflict() {
    const theirs = await asked("state");
    const answer = await ask("This home was changed elsewhere", [el("p", {}, "Another tab or program has saved other changes since. Keep what this tab shows, or take theirs? (Undo brings yours back.)")], "Keep mine", { other: { text: "Take theirs", value: "theirs" } });
    if (answer === "theirs") this.take(theirs);
    else if (answer) { this.revision = theirs.revision; this.#timer = setTimeout(() => this.flush(), 0); }
    else this.app.say("Not saved: it was changed elsewhere, too. The next change asks again.");
  }
  /** Replace the editor's document by the server's. */
  take(found) {
    const { app } = this;
    this.revision = found.revision;
    for (const { name } of found.photos) if (!app.thumbs.has(name)) app.thumbs.set(name, photoUrl(name));
    const state = editorState(found, app.rules);
    this.#kept = state;
    this.#notes = app.notes = found.notes;
    app.store.open(state);
    this.#kept = app.store.state;
    clearTimeout(this.#timer);
  }
  /** If the server has another revision, load what another tab has saved. */
  async look(revision) {
    if (revision === this.revision || this.pending) return;
    const found = await asked("state");
    if (found.revision !== this.revision && !this.pending) { this.take(found); this.app.say("Changed in another tab"); }
  }

  async photo(file) {
    const { max_photo: most } = this.app.rules;
    if (file.size > most) throw new Error(`at most ${most / 1e6} MB, and it has ${Math.ceil(file.size / 1e6)}`);
    await asked(photoUrl(file.name), { method: "PUT", body: file });
    return photoUrl(file.name);
  }
  /** Upload a picture, or one of each storey; resolves to the server's copy and the plan traced from it. */
  async picture(...files) {
    const found = await this.read(...files);
    if (!found.picture) throw new Error("a plan, not a picture");
    return found;
  }
  /** Open a plan of another format, which the server reads. */
  async openOther(file) {
    await this.show(await this.read(file), file);
  }
  /** Let the server read a file; ask the user for a scale or layers if they are needed. */
  async read(...files) {
    let found;
    const parts = files.length > 1 ? `?parts=${encodeURIComponent(JSON.stringify(files.map(({ name, size }) => [name, size])))}` : "";
    try { found = await asked(`plan${parts}`, { method: "POST", body: new Blob(files) }); } catch (error) {
      if (!error.reading) throw error;
      this.source = true;
      found = await this.askUntilRead(error.reading, error.message);
      if (!found) throw error;
    }
    this.source = true;
    return found;
  }
  /** Read the opened file again with other values. */
  async readAgain() {
    try {
      const reading = await asked("plan/reading"), doubt = reading.doubt && "Its scale is a guess: give its width, or close this and click two points with the tool Scale.";
      const found = await this.askUntilRead(reading, doubt);
      if (found) await this.show(found);
    } catch (error) { this.app.say(error.message); }
  }
  /** Ask for scale and layers until the server can read the plan; null if the user gives up. */
  async askUntilRead(reading, line) {
    let typed = null;
    for (;;) {
      const answer = await askReading(reading, typed, line, this.app.feet);
      if (!answer) return null;
      typed = answer.data;
      try { return await asked("plan/reading", { method: "POST", body: JSON.stringify(answer.given) }); } catch (error) {
        if (error.status !== 400) throw error;
        line = error.message;
        reading = error.reading ?? reading;
      }
    }
  }
  /** Replace the plan by the one that was read; undo brings the old plan back. */
  async show({ plan, picture, notes, scale, photos }, file) {
    const { app } = this;
    Object.assign(app, { notes: notes ?? [], doubt: scale?.doubt ?? "" });
    this.addKept(photos ?? []);
    if (!picture) { await app.openPlan(plan, file); return; }
    app.picture = picture;
    app.store.changeWhole({ picture: app.placed(picture), ...(plan ? { plan: completed(plan, app.rules) } : {}) });
    app.setTool("select");
    app.fit();
  }
  /** Add photos that the server found in the plan's file. */
  addKept(names) {
    const { app } = this, { photos } = app.store.state;
    const added = names.filter((name) => !photos.some((photo) => photo.name === name));
    for (const name of added) app.thumbs.set(name, photoUrl(name));
    if (added.length) app.store.change({ photos: [...photos, ...added.map((name) => ({ name, rooms: [] }))] });
  }
  /** The panel's button that opens the dialog of the plan file's scale and layers. */
  planTools() {
    return this.source ? button("How the plan file is read\u2026", () => this.readAgain(), { className: "wide" }) : null;
  }
}
