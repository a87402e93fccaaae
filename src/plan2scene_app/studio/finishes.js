// What the owner sets by hand: a surface is clicked in the viewer, its finish chosen here. Kept at
// once; shown at once where it is a colour, and made when the run is through.

import { labelOf } from "./document.js";
import { button, el } from "./dom.js";
import { asked } from "./server.js";

const HASTE = 1200; // milliseconds from the last choice to the run
const KINDS = /^(floor|ceiling|wall(\..+)?|door|trim)$/;
const WHITE = "#eceae7"; // as it is shown until the run is through

export class Finishes {
  rows = []; undone = []; surface = null;

  constructor(view, library) {
    Object.assign(this, { view, library, node: el("section", { id: "finishes" }) });
    window.addEventListener("message", (event) => this.hear(event));
    asked("finishes").then(({ rows }) => { this.rows = rows; this.render(); }, (error) => view.tell(error.message));
  }
  get frame() { return document.querySelector("#results iframe")?.contentWindow; }

  /** The viewer says which surface was clicked. */
  hear({ source, data }) {
    if (source !== this.frame || data?.kind !== "surface") return;
    const { room, surface } = data;
    this.surface = typeof room === "string" && KINDS.test(surface) ? { room, surface, title: String(data.title).slice(0, 80) } : null;
    this.render();
  }
  of(room, surface) { return this.rows.find((row) => row[0] === room && row[1] === surface)?.[2]; }

  /** Set a surface; null leaves it as found. */
  set(room, surface, what) {
    const others = this.rows.filter((row) => row[0] !== room || row[1] !== surface);
    return this.keep(what === null ? others : [...others, [room, surface, what]], { room, surface, what });
  }
  async keep(rows, changed) {
    const before = this.rows;
    try {
      ({ rows: this.rows } = await asked("finishes", { method: "PUT", body: JSON.stringify({ rows }) }));
    } catch (error) { this.view.tell(error.message); return; }
    this.undone = [...this.undone, before];
    this.view.tell("");
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

  render() {
    const { rooms } = this.view.app.store.state.plan, label = (id) => labelOf(rooms.find((room) => room.id === id) ?? { id });
    const lines = this.rows.map(([room, surface, what]) => el("li", {}, el("span", {}, `${room === "*" ? "all rooms" : label(room)}, ${surface}: ${what}`),
      button("\u00d7", () => this.set(room, surface, null), { title: "As found", "aria-label": `${label(room)} ${surface} as found` })));
    this.node.replaceChildren(el("h2", {}, "Set by hand"),
      this.surface ? this.choices(this.surface) : el("p", { className: "soft" }, "Click a wall, floor, ceiling, door, skirting board or window frame in the house to say what it is."),
      ...(lines.length ? [el("ul", { className: "list set" }, lines)] : []),
      ...(this.undone.length ? [button("Undo", () => this.undo())] : []));
  }
  choices({ room, surface, title }) {
    const now = this.of(room, surface), kind = surface.split(".")[0], set = (what) => this.set(room, surface, what);
    const colour = el("input", { type: "color", value: /^#/.test(now ?? "") ? now : "#d8d2c4", "aria-label": `Colour of ${title}`, onchange: (event) => set(event.target.value) });
    const choose = (label, entries) => el("select", { "aria-label": `${label} for ${title}`, onchange: (event) => event.target.value && set(event.target.value) },
      el("option", { value: "" }, label), entries.map(([value, name]) => el("option", { value }, name)));
    const { plan, photos } = this.view.app.store.state, rooms = plan.rooms.filter(({ id }) => id !== room);
    return el("div", {}, el("p", {}, el("b", {}, title), now ? `: ${now}` : ""),
      el("div", { className: "row" }, button("White", () => set("white")), el("label", { className: "check" }, colour, "Colour"), now ? button("As found", () => set(null)) : null),
      ["door", "trim"].includes(kind) ? null : el("div", { className: "row" },
        choose("Material\u2026", Object.keys(this.library).map((name) => [name, name])),
        choose("Same as in\u2026", rooms.map((other) => [`same:${other.id}`, labelOf(other)])),
        choose("As in photo\u2026", photos.map(({ name }) => [`photo:${name}`, name]))));
  }
}
