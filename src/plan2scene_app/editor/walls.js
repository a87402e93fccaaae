// Walls along the outlines of rooms and the openings on them, as the reader of plan.json makes them
// (plans/geometry.py and plans/openings.py).

import { add, cross, dist, dot, edgesOf, mid, ringsOf, sub, times, unit } from "./geometry.js";

/** A ring without repeated neighbouring points and without a closing point. */
export function cleanRing(points, same) {
  const kept = [];
  for (const p of points) if (!kept.length || dist(p, kept.at(-1)) > same) kept.push(p);
  while (kept.length > 1 && dist(kept[0], kept.at(-1)) <= same) kept.pop();
  return kept;
}

/**
 * Walls of rooms: {rooms: [room indices], start, end, height, openings: []}.
 * Edges are split where another room's corner lies on them; a piece that two rooms share is one wall.
 */
export function wallsOf(rooms, shared) {
  const corners = rooms.flatMap((room) => ringsOf(room).flat());
  const walls = [];
  rooms.forEach((room, number) => {
    for (const ring of ringsOf(room))
      for (const [start, end] of edgesOf(ring)) {
        const points = splitEdge(start, end, corners, shared);
        for (let k = 1; k < points.length; k++) addPiece(walls, points[k - 1], points[k], number, shared);
      }
  });
  const counts = new Map();
  for (const wall of walls) {
    const owner = wall.rooms[0], count = counts.get(owner) ?? 0;
    counts.set(owner, count + 1);
    wall.id = `${rooms[owner].id}_wall_${count}`;
    wall.height = Math.max(...wall.rooms.map((k) => rooms[k].height));
  }
  return walls;
}

function splitEdge(start, end, corners, tolerance) {
  const length = dist(start, end), way = unit(sub(end, start));
  const found = [];
  for (const corner of corners) {
    const offset = sub(corner, start), along = dot(offset, way);
    if (along > tolerance && along < length - tolerance && Math.abs(cross(way, offset)) <= tolerance) found.push(along);
  }
  found.sort((a, b) => a - b);
  const points = [start];
  let last = 0;
  for (const along of found)
    if (along - last > tolerance) {
      last = along;
      points.push(add(start, times(way, along)));
    }
  return [...points, end];
}

function addPiece(walls, start, end, room, tolerance) {
  const limit = 1.5 * tolerance;
  const other = walls.find((wall) => wall.rooms.length === 1 && wall.rooms[0] !== room && (
    Math.max(dist(wall.start, start), dist(wall.end, end)) <= limit ||
    Math.max(dist(wall.start, end), dist(wall.end, start)) <= limit));
  if (other) other.rooms.push(room);
  else walls.push({ rooms: [room], start, end, openings: [] });
}

/** Projection of an opening on a wall: {wall, start, end (metres along it, not clipped), distance}, or null. */
export function matchOf(wall, opening, limits) {
  const length = dist(wall.start, wall.end), way = unit(sub(wall.end, wall.start));
  const offsets = [opening.from, opening.to].map((p) => sub(p, wall.start));
  const along = offsets.map((o) => dot(o, way)), across = offsets.map((o) => cross(way, o));
  const low = Math.min(...along), high = Math.max(...along);
  if (high - low <= 0 || Math.abs(across[1] - across[0]) > Math.tan(limits.max_angle) * (high - low)) return null;
  if (Math.min(high, length) - Math.max(low, 0) < limits.min_share * (high - low)) return null;
  return { wall, start: low, end: high, distance: Math.abs(across[0] + across[1]) / 2 };
}

/**
 * Put openings on the walls on which they lie: wall.openings gets {opening, start, end}.
 * Returns {lost, cut}: the openings without a wall, {opening, nearest}, and those that were clipped at
 * a wall's end, {opening, match, length}.
 */
export function placeOpenings(walls, openings, limits) {
  const lost = [], cut = [];
  for (const opening of openings) {
    const matches = walls.map((wall) => matchOf(wall, opening, limits)).filter(Boolean)
      .sort((a, b) => a.distance - b.distance);
    const near = matches.filter((m) => m.distance <= limits.snap_tolerance);
    if (!near.length) {
      lost.push({ opening, nearest: matches[0]?.distance ?? null });
      continue;
    }
    for (const match of onePerSide(near)) {
      const length = dist(match.wall.start, match.wall.end);
      const start = Math.max(match.start, 0), end = Math.min(match.end, length);
      if (Math.max(start - match.start, match.end - end) > 1e-3) cut.push({ opening, match, length });
      match.wall.openings.push({ opening, start, end });
    }
  }
  return { lost, cut };
}

function onePerSide(near) {
  const chosen = [near[0]], first = near[0].wall.rooms;
  if (first.length === 1) {
    const other = near.slice(1).find((m) => m.wall.rooms.length === 1 && m.wall.rooms[0] !== first[0]);
    if (other) chosen.push(other);
  }
  return chosen;
}

/** The wall nearest to a point: {wall, along (metres from its start), distance}; null without walls. */
export function nearestWall(walls, point) {
  let best = null;
  for (const wall of walls) {
    const length = dist(wall.start, wall.end), way = unit(sub(wall.end, wall.start));
    const along = Math.max(0, Math.min(length, dot(sub(point, wall.start), way)));
    const distance = dist(point, add(wall.start, times(way, along)));
    if (!best || distance < best.distance) best = { wall, along, distance, length, way };
  }
  return best;
}

/** A segment `width` long on a wall, centred at `along` metres but kept between the wall's ends. */
export function segmentOn(wall, along, width) {
  const length = dist(wall.start, wall.end), way = unit(sub(wall.end, wall.start));
  const half = Math.min(width, length) / 2;
  const centre = Math.max(half, Math.min(length - half, along));
  return [add(wall.start, times(way, centre - half)), add(wall.start, times(way, centre + half))];
}

/** Distance of an opening's middle from an edge if the opening can lie on it; otherwise Infinity. */
export function offEdge(opening, [a, b], limits) {
  const match = matchOf({ start: a, end: b }, opening, limits);
  return match ? Math.abs(cross(unit(sub(b, a)), sub(mid(opening.from, opening.to), a))) : Infinity;
}
