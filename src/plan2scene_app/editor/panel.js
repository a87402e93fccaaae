// The panel on the right: the selection, the photos, the problems.

import { labelOf, labelsOf, renameRoom, withRooms } from "./document.js";
import { button, el, field } from "./dom.js";
import { lengthField, section } from "./fields.js";
import { floorSection, stairsSection } from "./floors_panel.js";
import { dist, mid, polygonArea, ringsOf, roundPoint } from "./geometry.js";
import { photoCard, refusedLines } from "./photos.js";
import { withHeights } from "./storeys.js";
import { areaText, lengthText } from "./units.js";
import { nearestWall, segmentOn } from "./walls.js";

/** Rebuild the panel; the focus is kept, and while the user types in a field this waits. */
export function renderPanel(app, panel) {
  const active = document.activeElement, key = active?.dataset?.key, top = panel.scrollTop;
  if (panel.contains(active) && active.tagName === "INPUT" && active.type === "text" && active.value !== active.defaultValue) {
    active.addEventListener("blur", () => app.renderPanel(), { once: true });
    return;
  }
  panel.replaceChildren(floorSection(app), chosenSection(app), photoSection(app), problemSection(app));
  panel.scrollTop = top;
  const again = key && panel.querySelector(`[data-key="${CSS.escape(key)}"]`);
  again?.focus();
  if (again?.type === "text") again.select();
}

function chosenSection(app) {
  const { selection, store } = app;
  const room = selection?.kind === "room" && store.plan.rooms.find((r) => r.id === selection.id);
  const opening = selection?.kind === "opening" && store.plan.openings.find((o) => o.id === selection.id);
  if (room) return roomSection(app, room);
  if (opening) return openingSection(app, opening);
  const flight = selection?.kind === "stairs" && store.plan.stairs?.find((s) => s.id === selection.id);
  if (flight) return stairsSection(app, flight);
  const fixture = selection?.kind === "fixtures" && store.plan.fixtures?.find((f) => f.id === selection.id);
  if (fixture) return section("Fixture", el("p", { className: "soft" }, fixture.type.replace("_", " ")), button("Delete", () => app.remove(selection), { className: "danger" }));
  if (selection?.kind === "wall") return wallSection(app, selection.edge);
  return houseSection(app);
}

function houseSection(app) {
  const { store, feet } = app, { picture } = store.state, { plan } = store;
  const total = plan.rooms.reduce((sum, room) => sum + polygonArea(ringsOf(room)), 0);
  const labels = labelsOf(store.state.plan.rooms);
  const rooms = plan.rooms.map((room) => el("li", {}, button([el("span", { className: `swatch type-${room.types[0]?.toLowerCase()}` }), labels.get(room.id), el("span", { className: "soft" }, areaText(polygonArea(ringsOf(room)), feet))], () => app.select({ kind: "room", id: room.id }), { className: "line" })));
  return section("House",
    lengthField(app, "Wall thickness", "depth", plan.wall_depth, (v) => store.changePlan({ wall_depth: v })),
    plan.rooms.length ? null : el("p", { className: "soft" }, "Draw a room: press R and drag, or W and click corner by corner. Or open or drop a plan, or a picture of one, with its photos."),
    plan.rooms.length ? el("ul", { className: "list", id: "rooms" }, rooms) : null,
    plan.rooms.length ? el("p", { className: "soft" }, `${plan.rooms.length} rooms, ${areaText(total, feet)}`) : null,
    pictureRow(app, picture),
    app.host.planTools?.() ?? null);
}

function pictureRow(app, picture) {
  if (!app.picture || !picture) return button("Picture of a plan underneath\u2026", () => app.pickFile("image/*", (file) => app.openPicture(file)), { className: "wide" });
  const place = (changes) => app.store.change({ picture: { ...picture, ...changes } }, "picture");
  return el("div", { className: "picture-row" },
    el("label", { className: "field" }, el("span", {}, "Picture"), el("input", { type: "range", min: 0, max: 1, step: 0.05, value: picture.opacity, "data-key": "opacity", "aria-label": "How much the picture shows", oninput: (event) => place({ opacity: Number(event.target.value), visible: true }) })),
    el("div", { className: "row" },
      button(picture.visible ? "Hide" : "Show", () => place({ visible: !picture.visible })),
      button("Scale\u2026", () => app.setTool("scale")),
      button("Remove", () => app.store.change({ picture: null }))));
}

function roomSection(app, room) {
  const { store } = app;
  const change = (changes, merge = "") => store.change({ plan: withRooms(store.plan, (r) => (r.id === app.selection?.id ? { ...r, ...changes } : r)) }, merge);
  const setHeights = (of, height) => store.change({ plan: withHeights(withRooms(store.plan, (r) => (of(r) ? { ...r, height } : r))) });
  const chip = (type) => el("button", {
    type: "button", className: `type type-${type.toLowerCase()}`, "aria-pressed": String(room.types.includes(type)), "data-key": `type ${type}`,
    onclick: (event) => {
      const several = event.shiftKey || event.ctrlKey || event.metaKey;
      const without = room.types.filter((t) => t !== type);
      if (!several) change({ types: [type] });
      else change({ types: room.types.includes(type) ? (without.length ? without : room.types) : [...without, type] });
    },
  }, type);
  return section("Room",
    field("Name", "name", labelOf(room), (text, input) => rename(app, room.id, text, input)),
    lengthField(app, "Height", "height", room.height ?? app.rules.limits.default_height, (v) => setHeights((r) => r.id === app.selection?.id, v)),
    el("p", { className: "soft" }, `${areaText(polygonArea(ringsOf(room)), app.feet)}. An open plan may have several types: hold Shift.`),
    el("div", { className: "types", role: "group", "aria-label": "Types of the room" }, app.rules.room_types.map(chip)),
    el("div", { className: "row" },
      button("Height for all rooms", () => setHeights(() => true, room.height)),
      button("Delete", () => app.remove(app.selection), { className: "danger" })));
}

function rename(app, from, text, input) {
  const name = text.trim().replace(/\s+/g, " ").slice(0, 100), { rooms } = app.store.state.plan;
  const old = labelOf(rooms.find((room) => room.id === from));
  if (!name || rooms.some((room) => labelOf(room) === name && room.id !== from)) {
    if (name) app.say(`Another room is named ${name}`);
    input.value = old;
  } else if (name !== old) {
    const { to, ...changes } = renameRoom(app.store.state, from, name);
    app.selection = { kind: "room", id: to };
    app.store.changeWhole(changes);
  }
}

function openingSection(app, opening) {
  const { store } = app, set = (changes) => store.changePlan({ openings: store.plan.openings.map((o) => (o.id === opening.id ? { ...o, ...changes } : o)) });
  const kinds = Object.keys(app.rules.openings).map((kind) => el("button", { type: "button", "aria-pressed": String(kind === opening.kind), "data-key": kind, onclick: () => set({ kind, bottom: kind === "window" ? opening.bottom : 0 }) }, kind));
  const width = (v) => {
    const near = nearestWall(app.walls, mid(opening.from, opening.to));
    if (!near) return;
    const [from, to] = segmentOn(near.wall, near.along, v).map(roundPoint);
    set({ from, to });
  };
  return section(`${opening.kind} ${opening.id}`, el("div", { className: "row types", role: "group", "aria-label": "Kind" }, kinds),
    lengthField(app, "Width", "width", dist(opening.from, opening.to), width),
    lengthField(app, "From the floor", "bottom", opening.bottom, (bottom) => set({ bottom })),
    lengthField(app, "Up to", "top", opening.top, (top) => set({ top })),
    el("div", { className: "row" }, button("Delete", () => app.remove(app.selection), { className: "danger" })));
}

function wallSection(app, edge) {
  const add = (kind) => {
    const tool = app.tools.find((t) => t.name === kind);
    tool.down(mid(...edge), { altKey: true });
  };
  return section("Wall", el("p", { className: "soft" }, `${lengthText(dist(...edge), app.feet)} long. Drag it, or move it by arrow keys.`),
    el("div", { className: "row" }, Object.keys(app.rules.openings).map((kind) => button(`+ ${kind}`, () => add(kind)))));
}

function photoSection(app) {
  const { photos } = app.store.state;
  const chosen = app.selection?.kind === "room" ? app.selection.id : null;
  const shown = chosen ? photos.filter((photo) => photo.rooms.includes(chosen)) : [...photos].sort((a, b) => Boolean(a.rooms.length) - Boolean(b.rooms.length));
  return section(chosen ? `Photos of ${labelOf(app.store.state.plan.rooms.find((room) => room.id === chosen))}` : "Photos",
    shown.length ? el("div", { className: "photos" }, shown.map((photo) => photoCard(app, photo))) : el("p", { className: "soft" }, "Drop photos on a room. One that shows two rooms is dropped on both."),
    ...refusedLines(app),
    button("Add photos\u2026", () => app.pickPhotos(chosen), { className: "wide" }));
}

/** A line of text in which names of rooms and openings are links to them. */
function linked(app, line) {
  const { plan } = app.store.state, rooms = new Set(plan.rooms.map((room) => room.id)), openings = new Set(plan.openings.map((o) => o.id));
  return line.split(/([A-Za-z0-9_-]+)/).map((word) => {
    const entry = openings.has(word) ? { opening: word } : rooms.has(word) ? { room: word } : null;
    return entry ? button(entry.room ? labelOf(plan.rooms.find((room) => room.id === word)) : word, () => app.showProblem(entry), { className: "lead" }) : word;
  });
}

/** A line without ids that the drawing does not show (ids of openings, walls and named rooms). */
function inWords(app, line) {
  const { plan } = app.store.state, names = new Map([...plan.openings.map(({ id, kind }) => [id, `the ${kind}`]), ...plan.rooms.map((room) => [room.id, labelOf(room)])]);
  return line.replace(/\b(opening|holes of wall|wall|room) ([\w.-]*\w)/g, (whole, what, id) => (what.endsWith("wall") ? `${what.replace("holes", "doors and windows").replace(/wall$/, "the wall")}` : names.get(id) ?? whole))
    .replace(/[\w-]*[\d_][\w-]*/g, (id) => names.get(id) ?? id);
}

function problemSection(app) {
  const labels = labelsOf(app.store.state.plan.rooms);
  const lines = app.problems.map((problem) => el("li", { className: problem.level },
    button([el("b", {}, `${labels.get(problem.room) || problem.room || problem.opening || problem.photo || "Plan"}: `), inWords(app, `expected ${problem.expected}, found ${problem.found}`)], () => app.showProblem(problem), { className: "line" })));
  const drop = (line) => { app.notes = app.notes.filter((other) => other !== line); app.host.changed?.(app); app.renderPanel(); };
  const told = app.store.state.picture?.measured ? app.doubt : ""; // two points have settled the scale
  for (const line of app.notes.filter((note) => note !== told)) lines.push(el("li", { className: "note" }, el("p", { className: "line" }, linked(app, line), button("\u00d7", () => drop(line), { title: "Seen", "aria-label": `Seen: ${line}` }))));
  const text = lines.length ? "Problems" : "No problems";
  return el("section", { id: "problems", "aria-live": "polite" }, el("h2", {}, text, lines.length ? el("span", { className: "count" }, String(lines.length)) : null),
    lines.length ? el("ul", { className: "list" }, lines) : null);
}
