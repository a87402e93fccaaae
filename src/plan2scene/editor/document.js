// The document: plan, photo table and place of the picture; every change makes a new state, so
// that undo is going back to an old one. Nothing in a state is ever changed in place.

export function newPlan(rules) {
  return { format: rules.format, version: 1, wall_depth: rules.limits.default_depth, rooms: [], openings: [] };
}

/** Holds the states and tells who listens. */
export class Store {
  #states; #at = 0; #saved; #listeners = []; #merge = "";

  constructor(state) {
    this.#states = [state];
    this.#saved = state;
  }
  get state() { return this.#states[this.#at]; }
  get plan() { return this.state.plan; }
  get canUndo() { return this.#at > 0; }
  get canRedo() { return this.#at < this.#states.length - 1; }
  get unsaved() { return this.state.plan !== this.#saved.plan || this.state.photos !== this.#saved.photos; }

  listen(listener) { this.#listeners.push(listener); }
  #tell() { for (const listener of this.#listeners) listener(); }

  /** Go to a changed state; changes with the same `merge` name in a row are one step of undo. */
  change(changes, merge = "") {
    const state = { ...this.state, ...changes };
    const before = merge && merge === this.#merge && this.#at > 0 ? this.#at : this.#at + 1;
    this.#states = [...this.#states.slice(Math.max(0, before - 300), before), state];
    this.#at = this.#states.length - 1;
    this.#merge = merge;
    this.#tell();
  }
  changePlan(changes, merge = "") { this.change({ plan: { ...this.plan, ...changes } }, merge); }

  /** Changes made from now on are a step of their own. */
  endStep() { this.#merge = ""; }
  undo() { if (this.canUndo) { this.#at--; this.#merge = ""; this.#tell(); } }
  redo() { if (this.canRedo) { this.#at++; this.#merge = ""; this.#tell(); } }
  markSaved(state = this.state) { this.#saved = state; this.#tell(); }

  /** Another document altogether: no way back to the old one but `undo`. */
  open(state) { this.change(state); this.markSaved(); }
}

export const openingId = (opening, k) => opening.id ?? `opening_${k}`;

/** An id that no entry has: name, name_2, name_3 ... */
export function freeId(name, entries) {
  const taken = new Set(entries.map((entry) => entry.id?.toLowerCase()));
  let id = name;
  for (let k = 2; taken.has(id.toLowerCase()); k++) id = `${name}_${k}`;
  return id;
}

/** Letters of an id: what is typed, made fit to name files. */
export const fitId = (text) =>
  text.normalize("NFKD").replace(/[\u0300-\u036f]/g, "").trim().replace(/[^A-Za-z0-9_.-]+/g, "_").replace(/^\.+/, "").slice(0, 60);

export function withRoom(plan, polygon, rules, types = ["Unknown"], height = null) {
  const id = freeId(types[0] === "Unknown" ? "room" : types[0].toLowerCase(), plan.rooms);
  const tall = height ?? plan.rooms.at(-1)?.height ?? rules.limits.default_height;
  return { plan: { ...plan, rooms: [...plan.rooms, { id, types, polygon, height: tall }] }, id };
}

export const withRooms = (plan, change) => ({ ...plan, rooms: plan.rooms.map(change) });

export function renameRoom(state, from, to) {
  return {
    plan: withRooms(state.plan, (room) => (room.id === from ? { ...room, id: to } : room)),
    photos: state.photos.map((photo) => ({ ...photo, rooms: photo.rooms.map((id) => (id === from ? to : id)) })),
  };
}

export function withoutRoom(state, id) {
  return {
    plan: { ...state.plan, rooms: state.plan.rooms.filter((room) => room.id !== id) },
    photos: state.photos.map((photo) => ({ ...photo, rooms: photo.rooms.filter((room) => room !== id) })),
  };
}

/** The plan as its file holds it. */
export const planText = (plan) => JSON.stringify(plan, null, 1).replace(/\[\s+(-?[\d.e+-]+),\s+(-?[\d.e+-]+)\s+\]/g, "[$1, $2]") + "\n";

/** The photo table as its file holds it. */
export function tableText(photos) {
  const cell = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const rows = photos.flatMap((photo) => photo.rooms.map((room) => `${cell(room)},${cell(photo.name)}`));
  return ["room_id,photo", ...rows].join("\n") + "\n";
}

/** Rows of a photo table as photos; throws a line where it is none. */
export function readTable(text) {
  const rows = text.replace(/^\ufeff/, "").split(/\r?\n/).filter((line) => line.trim())
    .map((line) => [...line.matchAll(/("(?:[^"]|"")*"|[^,]*)(,|$)/g)].map((m) => m[1].replace(/^"|"$/g, "").replaceAll('""', '"').trim()));
  if (!rows.length) return [];
  const room = rows[0].findIndex((name) => name === "room_id" || name === "roomId"), photo = rows[0].indexOf("photo");
  if (room < 0 || photo < 0) throw new Error("expected columns room_id and photo in the table");
  const photos = new Map();
  for (const row of rows.slice(1)) {
    if (!row[room] || !row[photo]) throw new Error("expected a room and a photo in each row of the table");
    const rooms = photos.get(row[photo]) ?? [];
    photos.set(row[photo], rooms.includes(row[room]) ? rooms : [...rooms, row[room]]);
  }
  return [...photos].map(([name, rooms]) => ({ name, rooms }));
}
