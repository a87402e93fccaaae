// Moves that keep a plan connected: shared corners, both sides of a wall, openings with their walls.

import { add, cross, dist, dot, edgesOf, inside, mid, nearestOn, ringsOf, roundPoint, sub, times, unit } from "./geometry.js";
import { withoutStraightCorners } from "./faces.js";
import { offEdge } from "./walls.js";

/** Largest distance in metres between the two sides of a wall. */
export const THICKEST = 0.45;

const withRings = (room, rings) => {
  const { holes, ...rest } = room;
  return rings.length > 1 ? { ...rest, polygon: rings[0], holes: rings.slice(1) } : { ...rest, polygon: rings[0] };
};

/** The plan with every corner at `from` moved to `to`; openings turn with their walls. */
export function movedCorner(plan, from, to, limits) {
  const near = (p) => dist(p, from) <= limits.shared_tolerance;
  const turned = [];
  const rooms = plan.rooms.map((room) => {
    const rings = ringsOf(room);
    if (!rings.flat().some(near)) return room;
    const changed = rings.map((ring) => ring.map((p) => (near(p) ? roundPoint(to) : p)));
    rings.forEach((ring, r) => edgesOf(ring).forEach((edge, k) => {
      if (edge.some(near)) turned.push([edge, edgesOf(changed[r])[k]]);
    }));
    return withRings(room, changed);
  });
  const openings = plan.openings.map((opening) => {
    const found = turned.find(([edge]) => offEdge(opening, edge, limits) <= limits.shared_tolerance);
    return found ? turnedOpening(opening, ...found, near) : opening;
  });
  return { ...plan, rooms, openings };
}

/** An opening on an edge that turned: it keeps its distance from the fixed end, if the edge is long enough. */
function turnedOpening(opening, [a, b], [c, d], near) {
  const [stay, was, is, goal] = near(a) ? [b, a, d, c] : [a, b, c, d];
  const old = unit(sub(was, stay)), way = unit(sub(goal, is)), length = dist(is, goal);
  const along = [opening.from, opening.to].map((p) => dot(sub(p, stay), old));
  const width = Math.min(Math.abs(along[1] - along[0]), length);
  const low = Math.max(0, Math.min(Math.min(...along), length - width));
  const ends = along[0] <= along[1] ? [low, low + width] : [low + width, low];
  const [from, to] = ends.map((v) => roundPoint(add(is, times(way, v))));
  return { ...opening, from, to };
}

/**
 * The plan with a wall moved along its normal by `distance` metres. `edge` is one side of a piece of
 * wall. Sides of other rooms that face it within `THICKEST` move with it, along the length of the
 * piece; a side that is longer than the piece gets a step.
 */
export function movedWall(plan, edge, distance, limits) {
  const [a, b] = edge, way = unit(sub(b, a)), normal = [-way[1], way[0]], shift = times(normal, distance);
  const length = dist(a, b), tolerance = limits.shared_tolerance;
  const moved = [];
  const rooms = plan.rooms.map((room) => {
    let touched = false;
    const rings = ringsOf(room).map((ring) => {
      const out = edgesOf(ring).map(([p, q]) => {
        const cut = facing(p, q);
        if (!cut) return [p];
        touched = true;
        moved.push([cut.from, cut.to]);
        const points = [];
        if (dist(p, cut.from) > tolerance) points.push({ keep: p }, { keep: cut.from });
        points.push({ move: cut.from }, { move: cut.to });
        if (dist(q, cut.to) > tolerance) points.push({ keep: cut.to });
        return points;
      });
      return touched ? joined(out, shift) : ring;
    });
    return touched ? withRings(room, rings) : room;
  });
  const openings = plan.openings.map((opening) =>
    moved.some((e) => offEdge(opening, e, limits) <= limits.snap_tolerance && nearestOn(...e, mid(opening.from, opening.to)).distance <= limits.snap_tolerance)
      ? { ...opening, from: roundPoint(add(opening.from, shift)), to: roundPoint(add(opening.to, shift)) } : opening);
  return { ...plan, rooms, openings };

  /** The part of side pq that faces the piece, in the direction of pq; null if there is none. */
  function facing(p, q) {
    const offsets = [p, q].map((c) => sub(c, a));
    if (Math.abs(cross(way, unit(sub(q, p)))) > 0.02) return null;
    const apart = offsets.map((o) => cross(way, o)), along = offsets.map((o) => dot(o, way));
    const low = Math.max(0, Math.min(...along)), high = Math.min(length, Math.max(...along));
    if (high - low <= tolerance) return null;
    const at = (v) => add(a, add(times(way, v), times(normal, apart[0])));
    const same = Math.max(...apart.map(Math.abs)) <= tolerance;
    if (!same) {
      // It is the other side of the same wall only if no room lies between the two.
      const between = add(a, add(times(way, (low + high) / 2), times(normal, apart[0] / 2)));
      if (Math.abs(apart[0]) > THICKEST || plan.rooms.some((room) => inside(ringsOf(room), between))) return null;
    }
    const slack = same ? tolerance : THICKEST;
    const near = (v, end, k) => (Math.abs(along[k] - v) <= slack ? end : at(v));
    return along[0] <= along[1] ? { from: near(low, p, 0), to: near(high, q, 1) } : { from: near(high, p, 0), to: near(low, q, 1) };
  }
}

/** A ring made from the points of its edges: points to move are shifted, others stay. */
function joined(edges, shift) {
  const points = [];
  edges.forEach((entries, k) => {
    for (const entry of entries) {
      if (Array.isArray(entry)) {
        // Start of an edge that stays. If the edge before it was moved up to here, its end replaces the start.
        const before = edges.at(k - 1).at(-1);
        if (!before.move) points.push(entry);
      } else if (entry.move) points.push(roundPoint(add(entry.move, shift)));
      else points.push(entry.keep);
    }
  });
  const ring = points.filter((p, k) => dist(p, points.at(k - 1)) > 1e-6);
  return withoutStraightCorners(ring.length >= 3 ? ring : points).map(roundPoint);
}

/** The plan with a room moved, together with the openings in walls of this room alone. */
export function movedRoom(plan, id, shift, walls) {
  const number = plan.rooms.findIndex((room) => room.id === id);
  const own = new Set(walls.filter((w) => w.rooms.includes(number) && w.rooms.length === 1).flatMap((w) => w.openings.map((o) => o.opening)));
  const shared = new Set(walls.filter((w) => !w.rooms.includes(number)).flatMap((w) => w.openings.map((o) => o.opening)));
  const go = (p) => roundPoint(add(p, shift));
  const rooms = plan.rooms.map((room) => (room.id === id ? withRings(room, ringsOf(room).map((ring) => ring.map(go))) : room));
  const openings = plan.openings.map((o) => (own.has(o) && !shared.has(o) ? { ...o, from: go(o.from), to: go(o.to) } : o));
  return { ...plan, rooms, openings };
}
