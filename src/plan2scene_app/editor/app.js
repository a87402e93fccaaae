// The editor: connects document, drawing, tools and panel, and handles pointer and keys.

import { entryId, newPlan, readTable, roomCalled, Store, withoutRoom } from "./document.js";
import { ask, button, el, field, isPicture, readFile, readPicture } from "./dom.js";
import { OpeningTool, RoomTool, WallTool } from "./drawing_tools.js";
import { add, boundsOf, dist, inside, ringsOf, roundPoint, sub, times } from "./geometry.js";
import { renderPanel } from "./panel.js";
import { addPhotos, listenToDrops, photoProblems } from "./photos.js";
import { problemsOf } from "./rules.js";
import { ScaleTool, SelectTool } from "./select_tool.js";
import { StairsTool } from "./stairs_tool.js";
import { levelsOf, sliceOf } from "./storeys.js";
import { lengthText, readLength } from "./units.js";
import { draw, View } from "./view.js";
import { placeOpenings, wallsOf } from "./walls.js";

const PICTURE_SIDE = 2400; // pixels

export class App {
  selection = null; dropRoom = null; problems = []; walls = []; thumbs = new Map(); refused = new Map(); picture = null; feet = false; notes = [];

  /** `start` is {house, plan, photos, picture, notes}; `host` loads and saves (files.js or studio/server.js). */
  constructor(rules, start, host, page) {
    Object.assign(this, { rules, host, page, house: start.house, notes: start.notes ?? [] });
    const plan = start.plan ?? newPlan(rules);
    this.picture = start.picture ?? null;
    this.doubt = start.scale?.doubt ?? "";
    this.store = new Store({ plan: completed(plan, rules), photos: start.photos ?? [], picture: this.picture ? this.placed(this.picture) : null });
    this.view = new View(page.svg);
    this.tools = [new SelectTool(this), new RoomTool(this), new WallTool(this), new OpeningTool(this, "door", "d", "Door"),
      new OpeningTool(this, "window", "n", "Window"), new OpeningTool(this, "passage", "p", "Passage"), new StairsTool(this), new ScaleTool(this)];
    this.tool = this.tools[0];
    this.store.listen(() => this.changed());
    this.toolButtons();
    this.listen();
    listenToDrops(this, page.svg);
    let shown = 0; // last width: after a large change (a turned phone) the plan is fitted again
    new ResizeObserver(() => {
      const width = page.svg.clientWidth, turned = width && shown && Math.abs(width / shown - 1) > 0.25;
      shown = width || shown;
      if (turned) this.fit(); else this.render();
    }).observe(page.svg);
    this.changed();
    this.fit();
    if (!plan.rooms.length) this.setTool(this.picture ? "scale" : "room");
  }

  /** Place of a new picture; if its scale is not known, it is 12 m wide. */
  placed(picture) {
    return { x: picture.x ?? 0, z: picture.z ?? 0, metres_per_pixel: picture.metres_per_pixel ?? 12 / picture.width, opacity: 0.6, visible: true };
  }

  changed() {
    const { photos, picture, plan: whole } = this.store.state, { plan } = this.store;
    this.walls = wallsOf(plan.rooms.filter((room) => Array.isArray(room.polygon)), this.rules.limits.shared_tolerance);
    placeOpenings(this.walls, plan.openings, this.rules.limits);
    this.problems = [...(whole.rooms.length ? this.check(whole) : []), ...photoProblems(photos, whole.rooms)];
    if (!picture && this.tool?.name === "scale" && !whole.rooms.length) this.setTool("room");
    const { selection } = this;
    if (selection?.kind === "room" && !plan.rooms.some((r) => r.id === selection.id)) this.selection = null;
    if (selection?.kind === "opening" && !plan.openings.some((o) => o.id === selection.id)) this.selection = null;
    if (["stairs", "fixtures"].includes(selection?.kind) && !plan[selection.kind]?.some((one) => one.id === selection.id)) this.selection = null;
    this.page.undo.disabled = !this.store.canUndo;
    this.page.redo.disabled = !this.store.canRedo;
    this.page.saved.textContent = this.store.unsaved ? "not saved" : "";
    this.host.changed?.(this);
    this.render();
    this.renderPanel();
  }
  render() {
    const picture = this.store.state.picture ? this.picture : null;
    const levels = levelsOf(this.store.state.plan), below = levels[levels.findIndex((level) => level.id === this.store.level) - 1];
    this.view.render({ state: { ...this.store.state, plan: this.store.plan }, below: below && sliceOf(this.store.state.plan, below.id), levels, limits: this.rules.limits, walls: this.walls, problems: this.problems, selection: this.selection, picture, feet: this.feet });
    this.drawOverlay();
  }
  /** Draw only the overlay again, which changes with the pointer. */
  refresh() { this.view.overlay.replaceChildren(); this.drawOverlay(); }
  drawOverlay() {
    if (this.tool.name !== "select") this.tools[0].draw(this.view);
    this.tool.draw(this.view);
    const room = this.dropRoom && this.store.plan.rooms.find((r) => r.id === this.dropRoom);
    if (room) draw(this.view.overlay, "path", { d: ringsOf(room).map((ring) => this.view.path(ring)).join(""), class: "drop" });
  }
  renderPanel() {
    if (this.panelDue) return;
    this.panelDue = true;
    requestAnimationFrame(() => { this.panelDue = false; renderPanel(this, this.page.panel); });
  }
  check(plan) { return problemsOf(plan, this.rules); }
  say(text) { this.page.status.textContent = text; }

  select(selection) {
    this.selection = selection;
    this.render();
    this.renderPanel();
  }
  setTool(name) {
    this.tool.cancel?.();
    this.tool = this.tools.find((tool) => tool.name === name);
    this.view.svg.style.cursor = this.tool.cursor;
    for (const node of this.page.tools.children) node.setAttribute("aria-pressed", String(node.dataset.tool === name));
    this.say(this.tool.hint);
    this.render();
  }
  remove(selection) {
    const { store } = this, { plan } = store;
    if (selection.kind === "room") store.changeWhole(withoutRoom(store.state, selection.id));
    else if (selection.kind === "opening") store.changePlan({ openings: plan.openings.filter((o) => o.id !== selection.id) });
    else if (["stairs", "fixtures"].includes(selection.kind)) store.changePlan({ [selection.kind]: plan[selection.kind].filter((one) => one.id !== selection.id) });
    else if (selection.kind === "corner") {
      const keep = (c) => dist(c, selection.point) > 0.01;
      const rooms = plan.rooms.map((room) => (room.polygon.length > 3 ? { ...room, polygon: room.polygon.filter(keep) } : room));
      store.changePlan({ rooms });
    } else { this.say("A wall goes with its room: delete the room"); return; }
    this.select(null);
  }
  /** Show the next floor up (1) or down (-1). */
  showNext(step) {
    const levels = levelsOf(this.store.state.plan), next = levels[levels.findIndex((level) => level.id === this.store.level) + step];
    if (next) { this.tool.cancel?.(); this.store.show(next.id); }
  }
  roomAt(p) { return [...this.store.plan.rooms].reverse().find((room) => inside(ringsOf(room), p)); }
  showProblem({ room, opening }) {
    const { plan } = this.store.state, entry = plan.openings.find((o) => o.id === opening) ?? plan.rooms.find((r) => r.id === room);
    if (entry?.level && entry.level !== this.store.level) this.store.show(entry.level);
    this.setTool("select");
    this.select(opening ? { kind: "opening", id: opening } : room ? { kind: "room", id: room } : null);
  }
  fit() {
    const { picture } = this.store.state, { plan } = this.store;
    const points = plan.rooms.flatMap((room) => room.polygon);
    if (picture && this.picture) points.push([picture.x, picture.z], [picture.x + this.picture.width * picture.metres_per_pixel, picture.z + this.picture.height * picture.metres_per_pixel]);
    this.view.fit(points);
    this.render();
  }

  async askScale(a, b) {
    const { store } = this, rooms = store.state.plan.rooms.length;
    const both = el("label", { className: "check" }, el("input", { type: "checkbox", name: "both", checked: true }), "Scale what is drawn, too");
    const data = await ask("How long is this in reality?", [
      field("Length", "length", lengthText(dist(a, b), this.feet), () => {}, { name: "length", inputMode: "decimal" }), rooms && store.state.picture ? both : null].filter(Boolean), "Set the scale",
      { check: (form) => this.doubtLength(form, dist(a, b)) });
    this.tool.cancel?.();
    if (!data) { this.refresh(); return; }
    const share = readLength(data.get("length"), this.feet) / dist(a, b), go = (p) => add(a, times(sub(p, a), share)), far = (p) => roundPoint(go(p));
    const { picture, plan } = store.state;
    const changes = {};
    if (picture) {
      const [x, z] = go([picture.x, picture.z]);
      changes.picture = { ...picture, x, z, metres_per_pixel: picture.metres_per_pixel * share, measured: true };
    }
    if (rooms && (!picture || data.get("both"))) changes.plan = { ...plan,
      rooms: plan.rooms.map((r) => ({ ...r, polygon: r.polygon.map(far), ...(r.holes ? { holes: r.holes.map((h) => h.map(far)) } : {}) })),
      ...Object.fromEntries(["openings", "stairs", "fixtures"].filter((key) => plan[key]).map((key) => [key, plan[key].map((one) => ({ ...one, from: far(one.from), to: far(one.to) }))])) };
    store.changeWhole(changes);
    this.fit();
    this.setTool(rooms ? "select" : "room");
  }

  /** A question, as nodes, about a length typed for a drawn one that may have another unit; null if it is clear. */
  doubtLength(form, drawn) {
    const input = form.elements.namedItem("length"), text = input.value.trim(), length = readLength(text, this.feet);
    if (!(length > 0)) return [`A length such as ${lengthText(3.2, this.feet)}, not ${text}`];
    const { picture, plan } = this.store.state, points = plan.rooms.flatMap((room) => room.polygon);
    const sides = picture && this.picture ? [this.picture.width, this.picture.height].map((side) => side * picture.metres_per_pixel) : sub(boundsOf(points).high, boundsOf(points).low);
    const wide = (length / drawn) * Math.max(...sides);
    if (!/^[\d.,]+$/.test(text) || wide <= this.rules.limits.usual_extent) return null;
    const take = (unit) => { input.value = `${text} ${unit}`; form.requestSubmit(); };
    return [`${text} of what? In ${this.feet ? "feet" : "metres"} the whole would be ${lengthText(wide, this.feet)} wide. `, ...(this.feet ? ["in", "ft"] : ["mm", "cm", "m"]).map((unit) => button(`${text} ${unit}`, () => take(unit)))];
  }

  /** Put a picture under the plan; if the host has traced it and nothing is drawn yet, show the traced plan. Several pictures are storeys. */
  async openPicture(file, ...more) {
    this.say(`Reading ${[file, ...more].map(({ name }) => name).join(", ")}\u2026`);
    let found;
    try { found = await (this.host.picture?.(file, ...more) ?? readPicture(file, PICTURE_SIDE).then((picture) => ({ picture }))); } catch (error) { this.say(`${file.name} is no picture that can be read (${error.message})`); return; }
    const traced = found.plan && !this.store.plan.rooms.length;
    this.picture = found.picture;
    this.notes = found.notes ?? [];
    this.doubt = found.scale?.doubt ?? "";
    this.store.change({ picture: this.placed(this.picture), ...(traced ? { plan: completed(found.plan, this.rules) } : {}) });
    this.fit();
    this.setTool(traced && !this.doubt ? "select" : "scale");
    if (traced && this.doubt) this.say(`Its scale is a guess. ${this.tool.hint}`);
  }
  /** Open a plan, a picture of one, or a photo table; resolves to why it cannot be read. */
  async openFile(file) {
    if (isPicture(file)) { await this.openPicture(file); return ""; }
    try {
      const text = await readFile(file);
      if (/^\s*\{/.test(text)) await this.openPlan(JSON.parse(text), file);
      else if (/^\ufeff?[^\n]*photo/i.test(text)) this.store.change({ photos: readTable(text).map(({ name, rooms }) => ({ name, rooms: rooms.map((room) => roomCalled(this.store.state.plan.rooms, room)) })) });
      else await this.host.openOther(file);
    } catch (error) { this.say(`${file.name}: ${error.message}`); return error.message; }
    return "";
  }
  async openPlan(plan, file) {
    if (plan.format !== this.rules.format) { await this.host.openOther(file); return; }
    const errors = this.check(plan).filter((p) => p.level === "error");
    const broken = !Array.isArray(plan.rooms) || !plan.rooms.every((r) => Array.isArray(r?.polygon) && Array.isArray(r.types)) || !(plan.openings ?? []).every((o) => Array.isArray(o?.from) && Array.isArray(o.to)) || !(plan.levels ?? []).every((l) => typeof l?.elevation === "number") || !(plan.stairs ?? []).every((s) => Array.isArray(s?.from) && Array.isArray(s.to));
    if (broken) throw new Error(`expected ${errors[0].expected}, found ${errors[0].found}`);
    this.store.open({ ...this.store.state, plan: completed(plan, this.rules) });
    this.select(null);
    this.setTool("select");
    this.fit();
  }
  pickFile(accept, use, multiple = false) {
    const input = el("input", { type: "file", accept, multiple, id: "file-input", onchange: () => { use(multiple ? [...input.files] : input.files[0]); input.remove(); } });
    input.hidden = true;
    document.getElementById("file-input")?.remove();
    document.body.append(input);
    input.click();
  }
  pickPhotos(room) { this.pickFile("image/*", (files) => addPhotos(this, files, room), true); }

  toolButtons() {
    this.page.tools.replaceChildren(...this.tools.map((tool) => button("", () => this.setTool(tool.name), { "data-tool": tool.name, title: `${tool.title} (${tool.key.toUpperCase()})`, "aria-pressed": String(tool === this.tool) })));
    this.tools.forEach((tool, k) => {
      const node = this.page.tools.children[k];
      node.append(el("span", { className: `icon ${tool.name}` }), el("span", {}, tool.title), el("kbd", {}, tool.key.toUpperCase()));
    });
  }

  listen() {
    const { svg } = this.page, { view } = this;
    let pan = null;
    svg.addEventListener("pointerdown", (event) => {
      svg.focus({ preventScroll: true });
      svg.setPointerCapture(event.pointerId);
      if (event.button === 1 || event.button === 2 || this.space) { pan = event; return; }
      this.tool.down(view.at(event), event);
      if (this.tool.drag?.pan) pan = event;
      this.refresh();
    });
    svg.addEventListener("pointermove", (event) => {
      if (pan) {
        view.offset = add(view.offset, [event.clientX - pan.clientX, event.clientY - pan.clientY]);
        pan = event;
        this.render();
      } else this.tool.move(view.at(event), event);
    });
    svg.addEventListener("pointerup", (event) => { if (!pan || this.tool.drag) this.tool.up?.(view.at(event), event); pan = null; });
    svg.addEventListener("dblclick", () => this.tool.double?.());
    svg.addEventListener("contextmenu", (event) => event.preventDefault());
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = svg.getBoundingClientRect();
      view.zoom(Math.exp(-event.deltaY * 0.0015), [event.clientX - box.left, event.clientY - box.top]);
      this.render();
    }, { passive: false });
    document.addEventListener("keydown", (event) => { if (this.keydown(event)) event.preventDefault(); });
    document.addEventListener("keyup", (event) => { if (event.key === " ") this.space = false; });
    window.addEventListener("beforeunload", (event) => { if (this.store.unsaved) event.preventDefault(); });
  }
  /** Handle a key; returns whether it was used. */
  keydown(event) {
    const key = event.key.toLowerCase();
    if (document.querySelector("dialog[open]")) return false;
    if (/^(INPUT|SELECT)$/.test(event.target.tagName)) {
      const done = key === "enter" || key === "escape" || ((event.ctrlKey || event.metaKey) && key === "s");
      if (!done) return false;
      this.view.svg.focus(); // further keys go to the drawing
    }
    if (event.ctrlKey || event.metaKey) {
      if (key === "z") return event.shiftKey ? this.store.redo() : this.store.undo(), true;
      if (key === "y") return this.store.redo(), true;
      if (key === "s") return this.host.save(this), true;
      return false;
    }
    if (event.target.tagName === "INPUT") return true;
    const button = event.target.tagName === "BUTTON";
    if (!(button && (key === "enter" || key === " ")) && this.tool.keydown(event)) return true;
    if (key === " " && !button) return (this.space = true);
    if (key === "escape") { if (!this.tool.cancel()) this.setTool("select"); this.render(); return true; }
    if ((key === "delete" || key === "backspace") && this.selection) { this.remove(this.selection); return true; }
    if (key === "f") { this.fit(); return true; }
    if (key === "+" || key === "=" || key === "-") { this.view.zoom(key === "-" ? 0.8 : 1.25); this.render(); return true; }
    if (key === "pageup" || key === "pagedown") { this.showNext(key === "pageup" ? 1 : -1); return true; }
    const tool = !event.altKey && this.tools.find((t) => t.key === key);
    if (tool) this.setTool(tool.name);
    return Boolean(tool);
  }
}

/** A plan with the reader's defaults: heights ("usual" if the plan gives none), wall thickness, ids. */
export function completed(plan, { limits }) {
  const heights = new Map((plan.levels ?? []).map((level) => [level.id, level.height ?? limits.default_height]));
  const rooms = plan.rooms.map((room) => ({ ...room, height: room.height ?? heights.get(room.level) ?? limits.default_height }));
  const found = { ...plan, wall_depth: plan.wall_depth ?? limits.default_depth, rooms, openings: (plan.openings ?? []).map((o, k) => ({ ...o, id: entryId(o, k, "opening") })) };
  if (![...plan.rooms, ...(plan.levels ?? [])].some((entry) => entry.height !== undefined)) found.heights = "usual";
  if (plan.levels) found.levels = plan.levels.map((level) => ({ ...level, height: heights.get(level.id) }));
  if (plan.stairs) found.stairs = plan.stairs.map((s, k) => ({ ...s, id: entryId(s, k, "stairs") }));
  if (plan.fixtures) found.fixtures = plan.fixtures.map((f, k) => ({ ...f, id: entryId(f, k, "fixture") }));
  return found;
}
