// Floors (levels) of a plan: slices, new floors, copies; the outlines of flights of stairs.

import { add, dist, roundPoint, sub, times, unit } from "./geometry.js";

const SLAB = 0.3; // metres from a ceiling to the floor above
const LISTS = ["rooms", "openings", "stairs", "fixtures"];

/** The plan without the mark "usual" of its heights: the user has set them, photos do not correct them. */
export const withHeights = ({ heights, ...plan }) => plan;

/** The floors, the lowest first. */
export const levelsOf = (plan) => [...(plan.levels ?? [])].sort((a, b) => a.elevation - b.elevation);

/** The plan with only what is on one floor; the whole plan if `level` is null. */
export function sliceOf(plan, level) {
  if (level === null) return plan;
  const own = LISTS.map((key) => [key, (plan[key] ?? []).filter((entry) => entry.level === level)]);
  return { ...plan, ...Object.fromEntries(own) };
}

/** The whole plan with the slice of one floor replaced. */
export function merged(plan, slice, level) {
  if (level === null) return slice;
  const whole = { ...slice, levels: plan.levels };
  for (const key of LISTS) {
    const mine = (slice[key] ?? []).map((entry) => (entry.level === level ? entry : { ...entry, level }));
    const old = plan[key] ?? [], first = old.findIndex((entry) => entry.level === level), others = old.filter((entry) => entry.level !== level);
    const place = first < 0 ? others.length : old.slice(0, first).filter((entry) => entry.level !== level).length;
    whole[key] = [...others.slice(0, place), ...mine, ...others.slice(place)];
  }
  for (const key of ["stairs", "fixtures"]) if (!whole[key].length && !plan[key]) delete whole[key];
  return whole;
}

/** An id that no entry has: name, name_2, name_3 ... */
export function freeId(name, entries) {
  const taken = new Set(entries.map((entry) => entry.id?.toLowerCase()));
  let id = name;
  for (let k = 2; taken.has(id.toLowerCase()); k++) id = `${name}_${k}`;
  return id;
}

/** The plan with floors: if it has none, everything is put on a new ground floor. */
function withLevels(plan, limits) {
  if (plan.levels?.length) return plan;
  const height = Math.max(0, ...plan.rooms.map((room) => room.height)) || limits.default_height;
  const levels = [{ id: "ground", name: "Ground floor", elevation: 0, height }];
  const on = (entries) => entries.map((entry) => ({ ...entry, level: "ground" }));
  return { ...plan, levels, rooms: on(plan.rooms), openings: on(plan.openings), ...(plan.stairs ? { stairs: on(plan.stairs) } : {}), ...(plan.fixtures ? { fixtures: on(plan.fixtures) } : {}) };
}

/** A plan with one more floor on top, or below all others: {plan, level (its id)}. */
export function withFloor(before, limits, below = false) {
  const plan = withLevels(before, limits), levels = levelsOf(plan), beside = below ? levels[0] : levels.at(-1);
  const climb = below ? -(beside.height + SLAB) : beside.height + SLAB;
  const elevation = Math.round((beside.elevation + climb) * 1000) / 1000;
  const level = freeId(below ? "basement" : "floor_1", levels);
  const name = level.replace("_", " ").replace(/^./, (letter) => letter.toUpperCase());
  return { plan: { ...plan, levels: [...plan.levels, { id: level, name, elevation, height: beside.height }] }, level };
}

/** A plan with a copy of a floor on top: rooms and openings, but not outer doors (ids in `outer`). */
export function withCopy(before, limits, from, outer) {
  const { plan, level } = withFloor(before, limits), source = from ?? "ground";
  const copies = (entries, skip = () => false) => entries.reduce((all, entry) => {
    if (entry.level !== source || skip(entry)) return all;
    return [...all, { ...entry, id: freeId(entry.id.replace(/_\d+$/, ""), all), level }];
  }, entries);
  const openings = copies(plan.openings, (opening) => opening.kind !== "window" && outer.has(opening.id));
  return { plan: { ...plan, rooms: copies(plan.rooms), openings }, level };
}

/** A state without one floor and everything on it; photos stay, without the rooms that are gone. */
export function withoutFloor(state, level) {
  const { plan, photos } = state, gone = new Set(plan.rooms.filter((room) => room.level === level).map((room) => room.id));
  const kept = LISTS.filter((key) => plan[key]).map((key) => [key, plan[key].filter((entry) => entry.level !== level)]);
  return {
    plan: { ...plan, ...Object.fromEntries(kept), levels: plan.levels.filter((one) => one.id !== level) },
    photos: photos.map((photo) => ({ ...photo, rooms: photo.rooms.filter((id) => !gone.has(id)) })),
  };
}

/** The plan with a changed floor; rooms that had the floor's old height get the new one. */
export function changedLevel(plan, level, changes) {
  const old = plan.levels.find((one) => one.id === level);
  const follows = (room) => room.level === level && changes.height !== undefined && room.height === old.height;
  return {
    ...(changes.height === undefined ? plan : withHeights(plan)),
    levels: plan.levels.map((one) => (one === old ? { ...one, ...changes } : one)),
    rooms: plan.rooms.map((room) => (follows(room) ? { ...room, height: changes.height } : room)),
  };
}

/** Rise of a flight in metres: to the next floor, or the default height of a room on the top floor. */
export function riseOf(flight, levels, limits) {
  const at = levels.findIndex((level) => level.id === flight.level), above = at >= 0 ? levels[at + 1] : undefined;
  return above ? above.elevation - levels[at].elevation : limits.default_height;
}

export const stepCount = (rise, limits) => Math.max(2, Math.ceil(rise / limits.riser - 1e-9));

/** The corners of the strip that a flight of stairs covers, beginning beside its foot. */
export function flightRing({ from, to, width }) {
  const way = unit(sub(to, from)), side = times([way[1], -way[0]], width / 2);
  return [add(from, side), add(to, side), sub(to, side), sub(from, side)];
}

/** A flight of stairs or a fixture, moved. */
export const movedEnds = (thing, by) => ({ ...thing, from: roundPoint(add(thing.from, by)), to: roundPoint(add(thing.to, by)) });

/** The corners of a fixture. */
export const fixtureRing = ({ from: [x0, z0], to: [x1, z1] }) => [[x0, z0], [x1, z0], [x1, z1], [x0, z1]];

export const flightLength = ({ from, to }) => dist(from, to);
