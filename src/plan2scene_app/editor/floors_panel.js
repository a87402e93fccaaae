// The panel's parts for floors and for stairs.

import { button, el, field } from "./dom.js";
import { lengthField, section } from "./fields.js";
import { changedLevel, flightLength, levelsOf, riseOf, stepCount, withCopy, withFloor, withoutFloor } from "./storeys.js";
import { lengthText, readLength } from "./units.js";

/** Section for floors: the choice of the shown floor, its height, and buttons to add floors. */
export function floorSection(app) {
  const { store, rules: { limits } } = app, whole = store.state.plan, levels = levelsOf(whole), { floor } = store;
  const go = ({ plan, level }) => {
    store.changeWhole({ plan });
    app.select(null);
    store.show(level);
    app.say("Draw this floor over the one below, or press PageDown to go back");
  };
  const outer = () => new Set(app.walls.filter((wall) => wall.rooms.length === 1).flatMap((wall) => wall.openings.map((hole) => hole.opening.id)));
  const buttons = el("div", { className: "row" },
    button("+ On top", () => go(withFloor(whole, limits)), { title: "An empty floor above all others" }),
    button("Copy to the top", () => go(withCopy(whole, limits, store.level, outer())), { title: "Rooms, windows and inner doors of this floor once more" }),
    button("+ Below", () => go(withFloor(whole, limits, true)), { title: "An empty floor below all others" }));
  if (!floor) return section("Floors", buttons);
  const change = (changes) => store.changeWhole({ plan: changedLevel(store.state.plan, store.level, changes) });
  const list = levels.reverse().map((level) => el("li", {}, button([level.name || level.id, el("span", { className: "soft" }, signed(level.elevation, app.feet))], () => store.show(level.id), { className: "line", "aria-pressed": String(level === floor) })));
  return section("Floors", el("ul", { className: "list", id: "floors" }, list), buttons,
    field("Floor name", "floor name", floor.name ?? floor.id, (text, input) => (text.trim() ? change({ name: text.trim().slice(0, 100) }) : (input.value = floor.name))),
    elevationField(app, floor, change),
    lengthField(app, "Ceilings at", "ceilings", floor.height, (height) => change({ height })),
    levels.length > 1 ? button("Remove this floor", () => store.changeWhole(withoutFloor(store.state, store.level)), { className: "danger" }) : null);
}

const signed = (metres, feet) => `${metres < 0 ? "\u2212" : ""}${lengthText(Math.abs(metres), feet)}`;

/** A field for a floor's elevation, below 0 for cellars. */
function elevationField(app, floor, change) {
  return field("Lies at", "elevation", signed(floor.elevation, app.feet), (text, input) => {
    const below = /^\s*[-\u2212]/.test(text), metres = readLength(text.replace(/^\s*[-\u2212+]/, ""), app.feet);
    if (Number.isNaN(metres)) { app.say(`A height such as ${lengthText(2.8, app.feet)}, not ${text}`); input.value = signed(floor.elevation, app.feet); } else change({ elevation: Math.round((below ? -metres : metres) * 1000) / 1000 });
  }, { inputMode: "decimal" });
}

/** Section for the selected flight of stairs. */
export function stairsSection(app, flight) {
  const { store, rules: { limits } } = app, set = (changes) => store.changePlan({ stairs: store.plan.stairs.map((s) => (s.id === flight.id ? { ...s, ...changes } : s)) });
  const rise = riseOf(flight, levelsOf(store.state.plan), limits), steps = stepCount(rise, limits);
  return section("Stairs",
    el("p", { className: "soft" }, `${steps} steps of ${lengthText(flightLength(flight) / steps, app.feet)}, ${lengthText(rise, app.feet)} up.`),
    lengthField(app, "Width", "flight width", flight.width, (width) => set({ width })),
    el("div", { className: "row" },
      button("Turn round", () => set({ from: flight.to, to: flight.from })),
      button("Delete", () => app.remove(app.selection), { className: "danger" })));
}
