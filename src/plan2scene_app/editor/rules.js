// The errors and warnings of the reader of plan.json, with the same texts. Schema, names and limits are
// taken from the reader (editor_page.py writes them into the page); tests/plan2scene_app/editor checks that
// both give the same results.

import { checkLevel, isOnLevel, readLevels, readStairs, storeyOddities, usedLevels } from "./storey_rules.js";
import { boundsOf, polygonArea, polygonDistance, ringsOf, selfCrossing, sharedArea } from "./geometry.js";
import { cleanRing, placeOpenings, wallsOf } from "./walls.js";

/** Problems of a plan: [{level: "error" | "warning", expected, found, room, opening}]. */
export function problemsOf(plan, rules) {
  const found = [];
  const tell = (level) => (expected, text, room = "", opening = "") => found.push({ level, expected, found: text, room, opening });
  const fault = tell("error"), warn = tell("warning");
  checkSchema(plan, rules.schema, rules.schema, "", fault, plan);
  if (found.length) return found;
  const { limits } = rules, named = readLevels(plan, limits, fault);
  const rooms = readRooms(plan, named, rules, fault, warn);
  if (found.some((p) => p.level === "error")) return found;
  const levels = usedLevels(named, rooms, warn), storeys = (levels.length ? levels.map((l) => l.id) : [undefined]).map((id) => rooms.filter((room) => room.level === id));
  const walls = readWalls(plan, rooms, storeys, levels, rules, fault, warn);
  const stairs = readStairs(plan, levels, rooms, limits, fault);
  roomFaults(rooms, rules, fault);
  if (found.some((p) => p.level === "error")) return found;
  unitFaults(rooms, rules, fault);
  for (const wall of walls) for (const hole of wall.openings) holeFault(wall, hole, rooms, rules, fault);
  for (const storey of storeys) overlaps(storey, rules, warn);
  holesApart(walls, rooms, rules, warn);
  oddities(rooms, storeys, walls, rules, warn);
  storeyOddities(stairs, levels, rooms, walls, limits, warn);
  return found;
}

const kindOf = (value) => (Array.isArray(value) ? "array" : value === null ? "null" : typeof value);
const show = (value) => { const text = JSON.stringify(value) ?? "nothing"; return text.length > 80 ? `${text.slice(0, 77)}...` : text; };

// What types and keywords of the schema demand, in the words of errors.py.
const TYPE_NAMES = { array: "a list", integer: "a whole number", object: "keys with values" };
const DEMANDS = {
  minItems: (n) => `at least ${n} entries`, maxItems: (n) => `at most ${n} entries`, maxLength: (n) => `at most ${n} characters`,
  minimum: (n) => `at least ${n}`, maximum: (n) => `at most ${n}`, exclusiveMinimum: (n) => `more than ${n}`,
  pattern: () => "only letters, digits, '_', '-' and '.'", uniqueItems: () => "each entry once",
};

/** The part of JSON Schema that plan.schema.json uses. */
function checkSchema(value, schema, root, place, fault, plan) {
  if (schema.$ref) schema = schema.$ref.slice(2).split("/").reduce((part, key) => part[key], root);
  const [, list, index] = place.match(/^(rooms|openings)\[(\d+)\]/) ?? [];
  const entry = list && plan[list][index], name = typeof entry?.id === "string" ? entry.id : "";
  const say = (expected, text = show(value)) =>
    fault(expected + (place ? ` at ${place}` : ""), text, list === "rooms" ? name : "", list === "openings" ? name : "");
  if ("const" in schema && value !== schema.const) return say(`'${schema.const}'`.replace(/^'(\d+)'$/, "$1"));
  if (schema.enum && !schema.enum.includes(value)) return say(`one of ${schema.enum.join(", ")}`);
  if (schema.type && kindOf(value) !== schema.type) return say(TYPE_NAMES[schema.type] ?? `a ${schema.type}`);
  const limits = {
    minItems: (n) => value.length >= n, maxItems: (n) => value.length <= n, maxLength: (n) => value.length <= n,
    minimum: (n) => value >= n, maximum: (n) => value <= n, exclusiveMinimum: (n) => value > n,
    pattern: (text) => new RegExp(text, "u").test(value),
    uniqueItems: () => new Set(value.map(show)).size === value.length,
  };
  for (const [key, holds] of Object.entries(limits))
    if (key in schema && !holds(schema[key])) return say(DEMANDS[key](schema[key]));
  if (schema.type === "object") {
    for (const key of schema.required ?? []) if (!(key in value)) return say(`key '${key}'`, "none");
    for (const key of Object.keys(value)) {
      if (schema.properties[key]) checkSchema(value[key], schema.properties[key], root, place ? `${place}.${key}` : key, fault, plan);
      else if (schema.additionalProperties === false) return say(`only the keys ${Object.keys(schema.properties).join(", ")}`, `'${key}'`);
    }
  } else if (schema.type === "array") value.forEach((item, k) => checkSchema(item, schema.items, root, `${place}[${k}]`, fault, plan));
}

function readRooms(plan, levels, rules, fault, warn) {
  const names = rules.room_types.join(", "), limits = rules.limits;
  let corners = 0;
  const rooms = plan.rooms.map((room) => {
    checkLevel(room, levels, `room ${room.id}`, (expected, text) => fault(expected, text, room.id));
    for (const type of room.types) {
      if (type.toLowerCase() in rules.types) continue;
      if (/^[a-z][a-z_]*$/.test(type)) warn(`a room type (${names})`, `'${type}', read as Unknown`, room.id);
      else fault(`a room type (${names})`, `'${type}'`, room.id);
    }
    const rings = ringsOf(room).map((ring) => {
      const far = ring.flat().find((v) => Math.abs(v) > limits.max_coordinate);
      if (far !== undefined) fault(`a coordinate within ${limits.max_coordinate} m (is the plan's scale in metres?)`, `${far}`, room.id);
      const kept = cleanRing(ring, limits.same_point);
      if (kept.length < 3) fault("an outline of at least 3 points", `${kept.length} points`, room.id);
      corners += kept.length;
      return kept;
    });
    const height = room.height ?? levels.find((level) => level.id === room.level)?.height ?? limits.default_height;
    return { id: room.id, rings, polygon: rings[0], holes: rings.slice(1), height, level: room.level };
  });
  const lacking = levels.length ? [] : plan.rooms.filter((room) => !("height" in room)).map((room) => room.id);
  if (lacking.length && lacking.length < rooms.length)
    warn("a height of every room, or of none", `none of ${lacking.join(", ").slice(0, 100)}; ${limits.default_height} m used`);
  if (corners > limits.max_corners) fault(`at most ${limits.max_corners} corners of all rooms`, `${corners}`);
  return rooms;
}

function readWalls(plan, rooms, storeys, levels, rules, fault, warn) {
  const limits = rules.limits, seen = new Set(), openings = [];
  (plan.openings ?? []).forEach((entry, k) => {
    const id = entry.id ?? `opening_${k}`;
    if (seen.has(id)) fault("each opening id once", `${id} twice`, "", id);
    seen.add(id);
    const far = [...entry.from, ...entry.to].find((v) => Math.abs(v) > limits.max_coordinate);
    if (far !== undefined) fault(`opening ${id} within ${limits.max_coordinate} m (is the plan's scale in metres?)`, `${far}`, "", id);
    if (entry.bottom >= entry.top) fault(`opening ${id} with its top above its bottom`, `${entry.bottom} to ${entry.top} m`, "", id);
    checkLevel(entry, levels, `opening ${id}`, (expected, text) => fault(expected, text, "", id));
    openings.push({ ...entry, id });
  });
  const groups = storeys.map((storey) => wallsOf(storey, limits.shared_tolerance).map((wall) => ({ ...wall, rooms: wall.rooms.map((k) => rooms.indexOf(storey[k])) })));
  groups.forEach((own, k) => {
    const others = groups.flatMap((walls) => (walls === own ? [] : walls)), level = storeys[k][0]?.level;
    const kept = openings.filter((opening) => opening.level === level && isOnLevel(opening, own, others, limits, warn));
    checkOpenings(own, kept, rooms, limits, fault, warn);
  });
  return groups.flat();
}

function checkOpenings(walls, openings, rooms, limits, fault, warn) {
  const { lost, cut } = placeOpenings(walls, openings, limits);
  for (const { opening, nearest } of lost) {
    const text = nearest === null ? "none along it" : `the nearest at ${nearest.toFixed(2)} m`;
    fault(`a wall within ${limits.snap_tolerance} m of opening ${opening.id}`, text, "", opening.id);
  }
  for (const { opening, match, length } of cut)
    warn(`opening ${opening.id} within its wall ${match.wall.id} of ${length.toFixed(3)} m`,
      `${match.start.toFixed(3)} to ${match.end.toFixed(3)} m, cut`, rooms[match.wall.rooms[0]].id, opening.id);
}

function roomFaults(rooms, rules, fault) {
  const counts = new Map();
  for (const room of rooms) counts.set(room.id, (counts.get(room.id) ?? 0) + 1);
  for (const [id, count] of counts) if (count > 1) fault("each room id once", `${id} ${count} times`, id);
  const least = rules.limits.min_area;
  for (const room of rooms) {
    const area = polygonArea(room.rings), at = selfCrossing(room.rings);
    if (at && sharedArea(room.rings, room.rings) >= least)
      fault("an outline that doesn't cross itself", `a crossing near ${at.map((v) => v.toFixed(2)).join(", ")}`, room.id);
    else if (area < least) fault(`an area of at least ${least} m2`, area.toFixed(4), room.id);
  }
}

const median = (values) => {
  const sorted = [...values].sort((a, b) => a - b), half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
};

function sizeOf(rooms) {
  const { low, high } = boundsOf(rooms.flatMap((room) => room.rings.flat()));
  return { extent: Math.max(high[0] - low[0], high[1] - low[1]), area: median(rooms.map((room) => polygonArea(room.rings))) };
}

function unitFaults(rooms, rules, fault) {
  const { extent, area } = sizeOf(rooms), limits = rules.limits, [low, high] = limits.heights;
  if (extent > limits.max_extent || area > limits.max_usual_area)
    fault(`a home in metres, at most ${limits.max_extent} m wide`, `${extent.toFixed(0)} m, its usual room ${area.toFixed(0)} m2 (are these centimetres?)`);
  for (const room of rooms)
    if (room.height < low || room.height > high) fault(`a height of ${low} to ${high} m`, `${room.height}`, room.id);
}

function holeFault(wall, { opening, end, start }, rooms, rules, fault) {
  const room = rooms[wall.rooms[0]].id, name = `hole ${opening.id} on wall ${wall.id}`;
  if (start >= end) fault(`${name} with a width`, `${start} to ${end} m`, room, opening.id);
  if (opening.bottom < -rules.limits.rounding || opening.top > wall.height + rules.limits.rounding)
    fault(`${name}, up within 0 to ${wall.height.toFixed(3)} m`, `${opening.bottom.toFixed(3)} to ${opening.top.toFixed(3)} m`, room, opening.id);
}

function overlaps(rooms, rules, warn) {
  const boxes = rooms.map((room) => boundsOf(room.rings[0]));
  const areas = rooms.map((room) => polygonArea(room.rings));
  rooms.forEach((one, i) => {
    for (let j = i + 1; j < rooms.length; j++) {
      if ([0, 1].some((k) => boxes[i].low[k] > boxes[j].high[k] || boxes[j].low[k] > boxes[i].high[k])) continue;
      const area = sharedArea(one.rings, rooms[j].rings);
      if (area > rules.limits.overlap_share * Math.min(areas[i], areas[j]))
        warn("rooms that don't overlap", `${area.toFixed(2)} m2 shared with room ${rooms[j].id}`, one.id);
    }
  });
}

function holesApart(walls, rooms, rules, warn) {
  for (const wall of walls) {
    const ordered = [...wall.openings].sort((a, b) => a.start - b.start);
    for (let k = 1; k < ordered.length; k++) {
      const [one, other] = [ordered[k - 1], ordered[k]];
      const low = Math.max(one.opening.bottom, other.opening.bottom), high = Math.min(one.opening.top, other.opening.top);
      if (one.end > other.start + rules.limits.rounding && low < high)
        warn(`holes of wall ${wall.id} apart`, `${one.opening.id} and ${other.opening.id}`, rooms[wall.rooms[0]].id, other.opening.id);
    }
  }
}

function oddities(rooms, storeys, walls, rules, warn) {
  const { extent, area } = sizeOf(rooms), limits = rules.limits;
  if (extent > limits.usual_extent) warn(`a home of at most ${limits.usual_extent} m`, `${extent.toFixed(0)} m`);
  const [least, most] = limits.usual_area, [low, high] = limits.usual_heights, [narrow, wide] = limits.usual_door;
  if (area < least || area > most) warn(`a usual room of ${least} to ${most} m2`, `${area.toFixed(2)} m2 (is the plan's unit the metre?)`);
  for (const room of rooms)
    if (room.height < low || room.height > high) warn(`a height of ${low} to ${high} m`, `${room.height}`, room.id);
  const doors = [];
  for (const wall of walls)
    for (const { opening, start, end } of wall.openings) {
      if (opening.kind === "door") doors.push(end - start);
      if (end - start < limits.narrow)
        warn(`hole ${opening.id} of at least ${limits.narrow} m`, `${(end - start).toFixed(3)} m`, rooms[wall.rooms[0]].id, opening.id);
    }
  const usual = doors.length ? median(doors) : narrow;
  if (usual < narrow || usual > wide) warn(`a usual door of ${narrow} to ${wide} m`, `${usual.toFixed(2)} m (is the plan's unit the metre?)`);
  for (const storey of storeys) islands(storey, limits, warn);
  nameOddities(rooms, rules, warn);
}

function islands(rooms, limits, warn) {
  const seen = new Set([0]), queue = [0], boxes = rooms.map((room) => boundsOf(room.rings[0]));
  const near = (i, j) => [0, 1].every((k) => boxes[i].low[k] - boxes[j].high[k] <= limits.apart && boxes[j].low[k] - boxes[i].high[k] <= limits.apart);
  while (queue.length) {
    const i = queue.pop();
    rooms.forEach((room, j) => {
      if (!seen.has(j) && near(i, j) && polygonDistance(rooms[i].rings, room.rings) <= limits.apart) { seen.add(j); queue.push(j); }
    });
  }
  const others = rooms.filter((_, k) => !seen.has(k));
  if (!others.length) return;
  const far = Math.min(...[...seen].map((k) => polygonDistance(rooms[k].rings, others[0].rings)));
  warn(`rooms within ${limits.apart} m of each other`, `${others.length} apart from the others, the first by ${far.toFixed(1)} m`, others[0].id);
}

function nameOddities(rooms, rules, warn) {
  const groups = new Map();
  for (const { id } of rooms) groups.set(id.toLowerCase(), [...(groups.get(id.toLowerCase()) ?? []), id]);
  for (const [lower, same] of groups) {
    if (same.length > 1) warn("room ids that differ by more than upper and lower case", `${same[0]} and ${same[1]}`, same[0]);
    if (rules.devices.includes(lower.split(".")[0])) warn("room ids that every system takes as a file name", same[0], same[0]);
  }
}
