// The reader's errors and warnings about floors and stairs (plans/levels.py), with the same texts.

import { dist, dot, inside, unit, sub, add, times } from "./geometry.js";
import { levelsOf, riseOf, stepCount } from "./storeys.js";
import { matchOf } from "./walls.js";

/** The floors, the lowest first; errors if two have the same id or nearly the same elevation. */
export function readLevels(plan, limits, fault) {
  const levels = levelsOf(plan).map((level) => ({ ...level, height: level.height ?? limits.default_height }));
  for (let k = 1; k < levels.length; k++) {
    const [level, above] = [levels[k - 1], levels[k]], same = levels.filter((one) => one.id === level.id).length;
    if (same > 1) fault("each level id once", `${level.id} ${same} times`);
    const apart = above.elevation - level.elevation;
    if (apart < limits.least_rise) fault(`levels ${level.id} and ${above.id} at least ${limits.least_rise} m apart`, `${apart.toFixed(2)} m`);
  }
  return levels;
}

/** Error if an entry names no floor of the plan, or names one in a plan without floors. */
export function checkLevel(entry, levels, what, fault) {
  const ids = levels.map((level) => level.id), named = entry.level;
  if (ids.length ? ids.includes(named) : named === undefined) return;
  fault(ids.length ? `one of the levels ${ids.join(", ")} for ${what}` : `levels, for ${what}`, named === undefined ? "none" : `'${named}'`);
}

/** The floors that have rooms; a warning for each other one. */
export function usedLevels(levels, rooms, warn) {
  const used = new Set(rooms.map((room) => room.level));
  for (const { id } of levels) if (!used.has(id)) warn(`rooms on level ${id}`, "none; left out");
  return levels.filter((level) => used.has(level.id));
}

/** False, with a warning, if an opening lies on a wall of another floor and on none of its own. */
export function isOnLevel(opening, own, others, limits, warn) {
  const fits = (walls) => walls.some((wall) => (matchOf(wall, opening, limits)?.distance ?? Infinity) <= limits.snap_tolerance);
  if (!others.length || fits(own) || !fits(others)) return true;
  warn(`opening ${opening.id} on a wall of its level ${opening.level}`, "one on a wall of another level; left out", "", opening.id);
  return false;
}

/** The flights of stairs with the rooms [lower, upper] that they join (null for no room). */
export function readStairs(plan, levels, rooms, limits, fault) {
  const seen = new Set();
  return (plan.stairs ?? []).map((entry, k) => {
    const id = entry.id ?? `stairs_${k}`, what = `stairs ${id}`;
    if (seen.has(id)) fault("each stairs id once", `${id} twice`);
    seen.add(id);
    const far = [...entry.from, ...entry.to].find((v) => Math.abs(v) > limits.max_coordinate);
    if (far !== undefined) fault(`a coordinate of ${what} within ${limits.max_coordinate} m (is the plan's scale in metres?)`, `${far}`);
    checkLevel(entry, levels, what, fault);
    const length = dist(entry.from, entry.to);
    if (length < limits.least_flight) fault(`${what} at least ${limits.least_flight} m long, with a width`, `${length.toFixed(2)} and ${entry.width.toFixed(2)} m`);
    return { ...entry, id, length, rooms: joinedRooms(entry, levels, rooms, limits) };
  });
}

function joinedRooms(flight, levels, rooms, limits) {
  const way = unit(sub(flight.to, flight.from)), at = levels.findIndex((level) => level.id === flight.level);
  const find = (end, sign, level) => {
    for (const off of [limits.step_off, -0.05]) {
      const spot = add(end, times(way, sign * off)), room = rooms.find((one) => one.level === level && inside(one.rings, spot));
      if (room) return room.id;
    }
    return null;
  };
  const above = at >= 0 ? levels[at + 1] : undefined;
  return [find(flight.from, -1, flight.level), above ? find(flight.to, 1, above.id) : null];
}

/** Length in metres of the part of a wall inside a flight's strip, which is shrunk by a margin. */
function metresAcross(wall, flight, margin) {
  const way = unit(sub(flight.to, flight.from)), side = [-way[1], way[0]], half = flight.width / 2 - margin;
  const [a, b] = [wall.start, wall.end].map((point) => { const off = sub(point, flight.from); return [dot(off, way), dot(off, side)]; });
  let [low, high] = [0, 1];
  for (const [axis, least, most] of [[0, margin, flight.length - margin], [1, -half, half]]) {
    const step = b[axis] - a[axis], ends = [(least - a[axis]) / step, (most - a[axis]) / step].sort((p, q) => p - q);
    if (least >= most || (Math.abs(step) < 1e-9 && (a[axis] < least || a[axis] > most))) return 0;
    if (Math.abs(step) >= 1e-9) [low, high] = [Math.max(low, ends[0]), Math.min(high, ends[1])];
  }
  return Math.max(high - low, 0) * dist(wall.start, wall.end);
}

/** Warnings: floors without stairs; stairs to nowhere, too steep or across walls; too high ceilings. */
export function storeyOddities(stairs, levels, rooms, walls, limits, warn) {
  const at = (id) => levels.findIndex((level) => level.id === id);
  doorsIntoTheAir(at, rooms, walls, limits, warn);
  for (const flight of stairs) {
    const [lower, upper] = flight.rooms, above = at(flight.level) >= 0 ? levels[at(flight.level) + 1] : undefined, what = `stairs ${flight.id}`;
    if (lower === null) warn(`${what} from a room of their level`, "none at their foot");
    if (!above) warn(`a level above ${what}`, "none; they end at the ceiling", lower ?? "");
    else if (upper === null) warn(`a room of level ${above.id} at the head of ${what}`, "none", lower ?? "");
    const rise = above || lower === null ? riseOf(flight, levels, limits) : rooms.find((room) => room.id === lower).height;
    const tread = flight.length / stepCount(rise, limits);
    if (tread < limits.tread) warn(`steps of ${what} at least ${limits.tread} m deep`, `${tread.toFixed(2)} m (${flight.length.toFixed(2)} m for a rise of ${rise.toFixed(2)} m)`, lower ?? "");
    const near = walls.filter((wall) => [flight.level, above?.id].includes(rooms[wall.rooms[0]].level));
    for (const wall of near) if (metresAcross(wall, flight, limits.flight_margin) > limits.flight_margin) warn(`${what} clear of walls`, "a wall across them", lower ?? "");
  }
  levels.slice(0, -1).forEach((level, k) => {
    if (!stairs.some((flight) => flight.level === level.id && !flight.rooms.includes(null))) warn(`stairs from level ${level.id} up to level ${levels[k + 1].id}`, "none");
  });
  for (const room of rooms) {
    const above = at(room.level) >= 0 ? levels[at(room.level) + 1] : undefined;
    const limit = above && above.elevation - levels[at(room.level)].elevation;
    if (above && room.height > limit + 1e-6) warn(`a ceiling below level ${above.id}, ${short(limit)} m up`, `${room.height} m`, room.id);
  }
}

/** Warnings for doors of higher floors that have no room behind them. */
function doorsIntoTheAir(at, rooms, walls, limits, warn) {
  const beside = new Map();
  for (const wall of walls) for (const { opening } of wall.openings) beside.set(opening, [...(beside.get(opening) ?? []), ...wall.rooms]);
  for (const [opening, around] of beside) {
    const room = rooms[around[0]], leads = new Set(around).size > 1;
    if (!leads && opening.kind === "door" && opening.bottom < limits.riser && at(room.level) > 0)
      warn(`a room or balcony behind door ${opening.id} of level ${room.level}`, "none", room.id);
  }
}

/** A number in the format of Python's :g. */
const short = (value) => `${Number(value.toPrecision(6))}`;
