// The document: plan, photo table and place of the picture. Every change makes a new state, and undo
// goes back to an old one. A state is never changed in place.

import { freeId, levelsOf, merged, sliceOf } from "./storeys.js";

export function newPlan(rules) {
  return { format: rules.format, version: 1, wall_depth: rules.limits.default_depth, heights: "usual", rooms: [], openings: [] };
}

/** Holds the states and notifies listeners. */
export class Store {
  #states; #at = 0; #saved; #listeners = []; #merge = ""; #level = null; #slice = {};

  constructor(state) {
    this.#states = [state];
    this.#saved = state;
    this.#keepLevel();
  }
  get state() { return this.#states[this.#at]; }
  /** The id of the floor that is shown; null in a plan without floors. */
  get level() { return this.#level; }
  get floor() { return levelsOf(this.state.plan).find((level) => level.id === this.#level) ?? null; }
  /** The plan of the shown floor, on which tools draw. The whole plan is `state.plan`. */
  get plan() {
    const { plan } = this.state;
    if (this.#slice.of !== plan || this.#slice.level !== this.#level) this.#slice = { of: plan, level: this.#level, plan: sliceOf(plan, this.#level) };
    return this.#slice.plan;
  }
  show(level) {
    this.#level = level;
    this.#tell();
  }
  /** If the shown floor no longer exists, show the floor nearest to elevation 0. */
  #keepLevel() {
    const levels = levelsOf(this.state.plan);
    if (levels.some((level) => level.id === this.#level)) return;
    this.#level = levels.sort((a, b) => Math.abs(a.elevation) - Math.abs(b.elevation))[0]?.id ?? null;
  }
  get canUndo() { return this.#at > 0; }
  get canRedo() { return this.#at < this.#states.length - 1; }
  get unsaved() { return this.state.plan !== this.#saved.plan || this.state.photos !== this.#saved.photos; }

  listen(listener) { this.#listeners.push(listener); }
  #tell() {
    this.#keepLevel();
    for (const listener of this.#listeners) listener();
  }

  /** As `changeWhole`, but `changes.plan` is only the plan of the shown floor. */
  change(changes, merge = "") {
    const whole = changes.plan ? { ...changes, plan: merged(this.state.plan, changes.plan, this.#level) } : changes;
    this.changeWhole(whole, merge);
  }
  /** Go to a changed state; successive changes with the same `merge` name are one step of undo. */
  changeWhole(changes, merge = "") {
    const state = { ...this.state, ...changes };
    const before = merge && merge === this.#merge && this.#at > 0 ? this.#at : this.#at + 1;
    this.#states = [...this.#states.slice(Math.max(0, before - 300), before), state];
    this.#at = this.#states.length - 1;
    this.#merge = merge;
    this.#tell();
  }
  changePlan(changes, merge = "") { this.change({ plan: { ...this.plan, ...changes } }, merge); }

  /** The next change begins a new step of undo. */
  endStep() { this.#merge = ""; }
  undo() { if (this.canUndo) { this.#at--; this.#merge = ""; this.#tell(); } }
  redo() { if (this.canRedo) { this.#at++; this.#merge = ""; this.#tell(); } }
  markSaved(state = this.state) { this.#saved = state; this.#tell(); }

  /** Open another document; only `undo` brings the old one back. */
  open(state) { this.changeWhole(state); this.markSaved(); }
}

export const entryId = (entry, k, name) => entry.id ?? `${name}_${k}`;

const WRITTEN = { æ: "ae", œ: "oe", ø: "o", ł: "l", đ: "d", ð: "d", þ: "th", ß: "ss", ı: "i", Æ: "Ae", Œ: "Oe", Ø: "O", Ł: "L", Đ: "D", Ð: "D", Þ: "Th" };

/** An id, fit for file names, made from a typed text; `otherwise` for a text in another script. */
export function fitId(text, otherwise = "room") {
  const id = text.replace(/[^\x00-\x7f]/g, (letter) => WRITTEN[letter] ?? letter).normalize("NFKD").replace(/[\u0300-\u036f]/g, "").replace(/[^A-Za-z0-9_.-]+/g, "_").replace(/^[._-]+|_+$/g, "").slice(0, 60);
  return (/[A-Za-z]/.test(id) || !/\p{L}/u.test(text)) && id ? id : otherwise;
}

/** A room's label: its name, or else its id. */
export const labelOf = (room) => room.name || room.id;

/** The labels of rooms by id: rooms of one name are told apart by their ids. */
export function labelsOf(rooms) {
  const names = rooms.map(labelOf), shared = (name) => names.indexOf(name) !== names.lastIndexOf(name);
  return new Map(rooms.map(({ id }, k) => [id, shared(names[k]) ? `${names[k]} (${id})` : names[k]]));
}

/** The id of the room that has a text as its id or, uniquely, as its name; the text itself if there is none. */
export function roomCalled(rooms, text) {
  const plain = (name) => name.normalize("NFKC").toLowerCase().trim().replace(/\s+/g, " ");
  const named = rooms.filter(({ id, name }) => [id, name || id].map(plain).includes(plain(text)));
  return rooms.some((room) => room.id === text) || named.length !== 1 ? text : named[0].id;
}

/** A floor's plan with one more room: {plan, id}; `others` are the rooms of all floors. */
export function withRoom(plan, polygon, others, height) {
  const id = freeId("room", [...others, ...plan.rooms]);
  return { plan: { ...plan, rooms: [...plan.rooms, { id, types: ["Unknown"], polygon, height }] }, id };
}

export const withRooms = (plan, change) => ({ ...plan, rooms: plan.rooms.map(change) });

export function renameRoom(state, from, name) {
  const to = freeId(fitId(name), state.plan.rooms.filter((room) => room.id !== from));
  return {
    plan: withRooms(state.plan, (room) => (room.id === from ? { ...room, id: to, name } : room)),
    photos: state.photos.map((photo) => ({ ...photo, rooms: photo.rooms.map((id) => (id === from ? to : id)) })),
    to,
  };
}

/** Height of a new room: that of the floor's last room, or else of the floor. */
export const usualHeight = (store, rules) => store.plan.rooms.at(-1)?.height ?? store.floor?.height ?? rules.limits.default_height;

export function withoutRoom(state, id) {
  return {
    plan: { ...state.plan, rooms: state.plan.rooms.filter((room) => room.id !== id) },
    photos: state.photos.map((photo) => ({ ...photo, rooms: photo.rooms.filter((room) => room !== id) })),
  };
}

/** The text of the plan's file. */
export const planText = (plan) => JSON.stringify(plan, null, 1).replace(/\[\s+(-?[\d.e+-]+),\s+(-?[\d.e+-]+)\s+\]/g, "[$1, $2]") + "\n";

/** The text of the photo table's file. */
export function tableText(photos) {
  const cell = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const rows = photos.flatMap((photo) => (photo.rooms.length ? photo.rooms : [""]).map((room) => `${cell(room)},${cell(photo.name)}`));
  return ["room_id,photo", ...rows].join("\n") + "\n";
}

/** The photos in the text of a photo table; throws an error if it is not one. */
export function readTable(text) {
  const lines = text.replace(/^\ufeff/, "").split(/\r?\n/).filter((line) => line.trim());
  if (!lines.length) return [];
  const mark = [",", ";", "\t"].find((each) => lines[0].includes(each)) ?? ",";  // spreadsheets differ
  const cells = new RegExp(`("(?:[^"]|"")*"|[^${mark}]*)(${mark}|$)`, "g");
  const rows = lines.map((line) => [...line.matchAll(cells)].map((m) => m[1].replace(/^"|"$/g, "").replaceAll('""', '"').trim()));
  const header = rows[0].map((name) => name.toLowerCase());
  const room = header.findIndex((name) => name === "room_id" || name === "roomid"), photo = header.indexOf("photo");
  const guess = header.indexOf("guess");  // a room that equals it is only a guess
  if (photo < 0) throw new Error("expected the columns room_id and photo in the table");
  const photos = new Map();
  for (const row of rows.slice(1)) {
    if (!row[photo]) throw new Error("expected a photo in each row of the table");
    const rooms = photos.get(row[photo]) ?? [];
    photos.set(row[photo], !row[room] || row[guess] === row[room] || rooms.includes(row[room]) ? rooms : [...rooms, row[room]]);
  }
  return [...photos].map(([name, rooms]) => ({ name, rooms }));
}
