// Turns drawn lines of walls into rooms: the faces, among all walls, that the new line bounds.

import { add, crossing, cross, dist, dot, edgesOf, inside, labelPoint, nearestOn, ringsOf, roundPoint, signedArea, sub, times, unit } from "./geometry.js";

/**
 * The changes of rooms after a line of walls was drawn.
 * Returns {made: [polygon rings], split: Map(room -> [polygons, largest first])}.
 */
export function drawnRooms(rooms, line, tolerance) {
  const lines = line.slice(1).map((p, k) => [line[k], p]);
  const graph = cutAll([...rooms.flatMap((room) => ringsOf(room).flatMap(edgesOf)), ...lines], tolerance);
  const faces = facesOf(graph).filter((ring) => Math.abs(signedArea(ring)) > 0.01);
  const made = [], split = new Map();
  for (const ring of faces) {
    const bounded = edgesOf(ring).some(([a, b]) => lines.some((l) => onLine(l, a, b, tolerance)));
    if (!bounded) continue;
    const point = labelPoint([ring]);
    const owner = rooms.find((room) => inside(ringsOf(room), point));
    const polygon = withoutStraightCorners(ring).map(roundPoint);
    if (!owner) made.push(polygon);
    else split.set(owner, [...(split.get(owner) ?? []), polygon]);
  }
  for (const [room, parts] of split) {
    parts.sort((a, b) => Math.abs(signedArea(b)) - Math.abs(signedArea(a)));
    if (parts.length < 2 || room.holes?.length) split.delete(room);
  }
  return { made, split };
}

const onLine = ([p, q], a, b, tolerance) => [a, b].every((c) => nearestOn(p, q, c).distance <= tolerance);

/** Segments split where they cross or touch each other; nodes are points at least `tolerance` apart. */
function cutAll(segments, tolerance) {
  const nodes = [];
  const nodeOf = (p) => {
    const k = nodes.findIndex((q) => dist(p, q) <= tolerance);
    return k >= 0 ? k : nodes.push(p) - 1;
  };
  const edges = new Set();
  for (const [a, b] of segments) {
    const length = dist(a, b);
    if (length <= tolerance) continue;
    const way = unit(sub(b, a)), cuts = [0, length];
    for (const [c, d] of segments) {
      const at = crossing(a, b, c, d), slack = tolerance / length, other = tolerance / (dist(c, d) || 1);
      if (at && at[0] > -slack && at[0] < 1 + slack && at[1] > -other && at[1] < 1 + other) cuts.push(at[0] * length);
      for (const p of [c, d]) if (nearestOn(a, b, p).distance <= tolerance) cuts.push(dot(sub(p, a), way));
    }
    const ends = cuts.map((v) => Math.max(0, Math.min(length, v))).sort((u, v) => u - v).map((v) => nodeOf(add(a, times(way, v))));
    for (let k = 1; k < ends.length; k++) if (ends[k] !== ends[k - 1]) edges.add([ends[k - 1], ends[k]].sort((u, v) => u - v).join());
  }
  return { nodes, edges: [...edges].map((e) => e.split(",").map(Number)) };
}

/** The ring around every bounded face, without loose ends. */
function facesOf({ nodes, edges }) {
  const around = new Map(nodes.map((_, k) => [k, new Set()]));
  for (const [a, b] of edges) { around.get(a).add(b); around.get(b).add(a); }
  const loose = [...around.keys()];
  while (loose.length) {
    const k = loose.pop(), near = around.get(k);
    if (near.size !== 1) continue;
    const [other] = near;
    near.clear();
    around.get(other).delete(k);
    loose.push(other);
  }
  const angle = (a, b) => Math.atan2(nodes[b][1] - nodes[a][1], nodes[b][0] - nodes[a][0]);
  const sorted = new Map([...around].map(([k, near]) => [k, [...near].sort((a, b) => angle(k, a) - angle(k, b))]));
  const seen = new Set(), rings = [];
  for (const [start, near] of sorted)
    for (const first of near) {
      if (seen.has(`${start},${first}`)) continue;
      const ring = [];
      let a = start, b = first;
      while (!seen.has(`${a},${b}`)) {
        seen.add(`${a},${b}`);
        ring.push(nodes[a]);
        const ways = sorted.get(b);
        [a, b] = [b, ways[(ways.indexOf(a) + ways.length - 1) % ways.length]];
      }
      if (signedArea(ring) > 0) rings.push(ring);
    }
  return rings;
}

/** A ring without corners on a straight line. */
export function withoutStraightCorners(ring) {
  const kept = ring.filter((p, k) => {
    const u = sub(p, ring.at(k - 1)), v = sub(ring[(k + 1) % ring.length], p);
    return Math.abs(cross(unit(u), unit(v))) > 1e-3 || dot(u, v) < 0;
  });
  return kept.length >= 3 ? kept : ring;
}
