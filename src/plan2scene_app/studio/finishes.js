// Finishes that the owner sets: a surface is clicked in the viewer, and its finish is chosen here. It is
// saved at once; a colour is also shown at once; the next run makes the textures.

import { labelsOf } from "./document.js";
import { ask, button, el } from "./dom.js";
import { asked } from "./server.js";

const HASTE = 1200; // milliseconds from the last choice until a run starts
const KINDS = /^(floor|ceiling|wall(\..+)?|door|trim)$/;
const WHITE = "#eceae7"; // colour shown for "white" until the run has made it
const SAID = { trim: "skirting and frames" };
const SHOWN = 420; // side in pixels of a picture from which a colour is picked

export class Finishes {
  rows = []; undone = []; surface = null;

  constructor(view, library) {
    Object.assign(this, { view, library, node: el("section", { id: "finishes" }) });
    this.plan = view.app.store.state.plan;
    view.app.store.listen(() => this.follow(view.app.store.state.plan));
    window.addEventListener("message", (event) => this.hear(event));
    asked("finishes").then(({ rows }) => { this.rows = rows; this.render(); }, (error) => view.tell(error.message));
  }
  get frame() { return document.querySelector("#results iframe")?.contentWindow; }

  /** Handle the viewer's message that names the clicked surface. */
  hear({ source, data }) {
    if (source !== this.frame || data?.kind !== "surface") return;
    const { room, surface } = data;
    this.surface = typeof room === "string" && KINDS.test(surface) ? { room, surface, title: String(data.title).slice(0, 80), place: String(data.place ?? "").slice(0, 200) } : null;
    this.render();
  }
  of(room, surface) { return this.rows.find((row) => row[0] === room && row[1] === surface)?.[2]; }

  /** Set a surface's finish; null removes it. */
  set(room, surface, what) {
    const others = this.rows.filter((row) => row[0] !== room || row[1] !== surface);
    return this.keep(what === null ? others : [...others, [room, surface, what]], { room, surface, what });
  }
  async save(rows) {
    ({ rows: this.rows } = await asked("finishes", { method: "PUT", body: JSON.stringify({ rows }) }));
    this.view.tell("");
  }
  /** Renamed rooms keep their finishes; a renamed room is recognised by its unchanged outline. */
  follow(plan) {
    const was = new Map(this.plan.rooms.map((room) => [room.polygon, room.id]));
    const now = new Map(plan.rooms.map((room) => [was.get(room.polygon), room.id]));
    const listed = ({ rooms, openings }) => JSON.stringify([rooms.map((room) => [room.id, room.name]), openings.map(({ id, kind }) => [id, kind])]), same = listed(plan) === listed(this.plan);
    this.plan = plan;
    if (!same) this.render();
    const named = (id) => now.get(id) ?? id, told = (rows) => rows.map(([room, surface, what]) => [named(room), surface, what.replace(/(?<=^same:).+/, named)]);
    if (JSON.stringify(told(this.rows)) === JSON.stringify(this.rows)) return;
    this.undone = this.undone.map(told);
    this.save(told(this.rows)).then(() => this.render(), (error) => this.view.tell(error.message));
  }
  async keep(rows, changed) {
    const before = this.rows;
    try { await this.save(rows); } catch (error) { this.view.tell(error.message); return; }
    this.undone = [...this.undone, before];
    const colour = changed && (changed.what === "white" ? WHITE : (this.library[changed.what] ?? changed.what));
    if (/^#[0-9a-f]{6}$/i.test(colour ?? "")) this.frame?.postMessage({ kind: "paint", room: changed.room, surface: changed.surface, colour }, "*");
    this.render();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.view.makeAgain(), HASTE);
  }
  async undo() {
    const before = this.undone.at(-1);
    const left = this.undone.slice(0, -1);
    await this.keep(before);
    this.undone = left;
    this.render();
  }

  /** The label of a room, or of a door by the rooms beside it. */
  label(id) {
    const { app } = this.view, labels = labelsOf(app.store.state.plan.rooms), room = labels.get(id);
    if (room || id === "*") return room ?? "all rooms";
    return app.walls.filter(({ openings }) => openings.some(({ opening }) => opening.id === id)).flatMap(({ rooms }) => rooms.map((k) => labels.get(app.store.plan.rooms[k].id))).join(" \u2013 ") || id;
  }
  words(what) { return what.replace(/^same:(.*)/, (_, id) => `as in ${this.label(id)}`).replace(/^photo:/, "as in photo "); }

  render() {
    const lines = this.rows.map(([room, surface, what]) => el("li", {}, el("span", {}, `${this.label(room)}, ${SAID[surface] ?? surface}: `, this.swatch(what), this.words(what)),
      button("\u00d7", () => this.set(room, surface, null), { title: "As found", "aria-label": `${this.label(room)} ${surface} as found` })));
    this.node.replaceChildren(el("h2", {}, "Set by hand"),
      this.surface ? this.choices(this.surface) : el("p", { className: "soft" }, "Click a wall, floor, ceiling, door, skirting board or window frame in the house to say what it is."),
      this.list(),
      ...(lines.length ? [el("ul", { className: "list set" }, lines)] : []),
      ...(this.undone.length ? [button("Undo", () => this.undo())] : []));
  }
  /** A list of all surfaces, for users of the keyboard or a screen reader. */
  list() {
    const { rooms, openings } = this.view.app.store.state.plan, entry = (room, surface) => ({ room, surface, title: `${this.label(room)}, ${SAID[surface] ?? surface}` });
    const all = [...rooms.flatMap(({ id }) => ["floor", "wall", "ceiling", "trim"].map((surface) => entry(id, surface))), ...openings.filter(({ kind }) => kind === "door").map(({ id }) => entry(id, "door"))];
    const choose = ({ target }) => { this.surface = all[target.selectedIndex - 1] ?? null; this.render(); this.node.querySelector(".surfaces").focus(); };
    const shown = (one) => one.room === this.surface?.room && one.surface === this.surface.surface;
    return el("select", { className: "surfaces", "aria-label": "Surface", onchange: choose }, el("option", {}, "A surface\u2026"), all.map((one) => el("option", { selected: shown(one) }, one.title)));
  }
  swatch(what) {
    const colour = this.library[what] ?? what, node = el("span", { className: "swatch" });
    node.style.setProperty("--fill", colour);
    return colour.startsWith("#") ? node : null;
  }
  choices({ room, surface, title }) {
    const now = this.of(room, surface), kind = surface.split(".")[0], set = (what) => this.set(room, surface, what);
    const colour = el("input", { type: "color", value: /^#/.test(now ?? "") ? now : "#d8d2c4", "aria-label": `Colour of ${title}`, onchange: (event) => set(event.target.value) });
    const choose = (label, entries) => el("select", { "aria-label": `${label} for ${title}`, onchange: (event) => event.target.value && set(event.target.value) },
      el("option", { value: "" }, label), entries.map(([value, name]) => el("option", { value }, name)));
    const { app } = this.view, { plan, photos } = app.store.state, rooms = plan.rooms.filter(({ id }) => id !== room);
    const pick = (name) => button(el("img", { src: app.thumbs.get(name) ?? "", alt: name, loading: "lazy" }), () => set(`photo:${name}`), { title: name, "aria-pressed": String(now === `photo:${name}`) });
    return el("div", {}, el("p", {}, el("b", {}, title), now ? `: ${this.words(now)}` : ""),
      el("div", { className: "row" }, button("White", () => set("white")), el("label", { className: "check" }, colour, "Colour"),
        button("From a picture\u2026", () => app.pickFile("image/*", (file) => this.takeColour(file, set))), now ? button("As found", () => set(null)) : null),
      ...(["door", "trim"].includes(kind) ? [] : [el("div", { className: "row" },
        choose("Material\u2026", Object.keys(this.library).map((name) => [name, name])),
        choose("Same as in\u2026", rooms.map((other) => [`same:${other.id}`, this.label(other.id)]))),
        photos.length ? this.view.folding("as in photo", false, "As in a photo\u2026", el("div", { className: "picks" }, photos.map(({ name }) => pick(name)))) : null].filter(Boolean)));
  }
  /** Show a picture; a click picks the colour at that point. */
  async takeColour(file, set) {
    let picture;
    try { picture = await createImageBitmap(file); } catch { this.view.tell(`${file.name} is no picture that can be read`); return; }
    const share = SHOWN / Math.max(picture.width, picture.height), [width, height] = [picture.width, picture.height].map((side) => Math.max(1, Math.round(side * share)));
    const canvas = el("canvas", { width, height, className: "pick" }), pen = canvas.getContext("2d"), input = el("input", { type: "color", name: "colour", "aria-label": "Colour that was taken" });
    pen.drawImage(picture, 0, 0, width, height);
    const take = (x, y) => { input.value = `#${[...pen.getImageData(x * width, y * height, 1, 1).data].slice(0, 3).map((v) => v.toString(16).padStart(2, "0")).join("")}`; };
    canvas.addEventListener("click", ({ offsetX, offsetY }) => take(offsetX / canvas.clientWidth, offsetY / canvas.clientHeight));
    take(0.5, 0.5);
    const data = await ask("Click the colour in the picture", [canvas, el("label", { className: "check" }, input, "is taken")], "Take it");
    if (data) set(data.get("colour"));
  }
}
