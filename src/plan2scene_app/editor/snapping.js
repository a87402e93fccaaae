// Snaps a pointer to corners, walls, lines through corners, multiples of 45 degrees, or the grid.

import { add, crossing, dist, dot, edgesOf, nearestOn, ringsOf, round, roundPoint, sub, times } from "./geometry.js";

const WAYS = [0, 1, 2, 3].map((k) => [Math.cos((k * Math.PI) / 4), Math.sin((k * Math.PI) / 4)]);

/** Grid step in metres that suits a zoom (pixels per metre). */
export const gridOf = (scale) => [0.05, 0.1, 0.5, 1].find((step) => step * scale >= 7) ?? 2;

/**
 * A snapped point: {point, kind, guides: [[a, b] ...]}.
 *
 * rooms   rooms whose corners and walls are used
 * scale   pixels per metre
 * from    the point from which a line is being drawn, or null
 * points  further corners: those of the line being drawn
 */
export function snap(pointer, { rooms, scale, from = null, points = [], free = false }) {
  if (free) return { point: roundPoint(pointer), kind: "free", guides: [] };
  const corners = [...rooms.flatMap((room) => ringsOf(room).flat()), ...points];
  const near = 11 / scale;
  const corner = nearestPoint(corners, pointer);
  if (corner && dist(corner, pointer) <= near) return { point: corner, kind: "corner", guides: [] };
  const edges = rooms.flatMap((room) => ringsOf(room).flatMap(edgesOf));
  const wall = nearestEdge(edges, pointer, near);
  const ray = from && nearestRay(from, pointer, scale);
  const guides = [];
  if (wall) return onWall(wall, ray, from, corners, pointer, near);
  if (ray) return onRay(ray, from, corners, edges, near, scale);
  const grid = gridOf(scale);
  const point = [0, 1].map((axis) => {
    const line = corners.filter((c) => Math.abs(c[axis] - pointer[axis]) <= near / 2)
      .sort((c, d) => Math.abs(c[axis] - pointer[axis]) - Math.abs(d[axis] - pointer[axis]))[0];
    if (line) guides.push(line);
    return line ? line[axis] : round(Math.round(pointer[axis] / grid) * grid);
  });
  return { point, kind: guides.length ? "guide" : "grid", guides: guides.map((g) => [g, point]) };
}

function nearestPoint(points, p) {
  return points.reduce((best, q) => (!best || dist(p, q) < dist(p, best) ? q : best), null);
}

function nearestEdge(edges, p, near) {
  let best = null;
  for (const edge of edges) {
    const found = nearestOn(...edge, p);
    if (found.distance <= near && (!best || found.distance < best.distance)) best = { ...found, edge };
  }
  return best;
}

/** The direction from `from` (a multiple of 45 degrees) to which the pointer is near; null for none. */
function nearestRay(from, pointer, scale) {
  const offset = sub(pointer, from), length = Math.hypot(...offset);
  if (length * scale < 6) return null;
  const found = WAYS.map((way) => ({ way, along: dot(offset, way), off: Math.abs(offset[0] * way[1] - offset[1] * way[0]) }))
    .sort((a, b) => a.off - b.off)[0];
  return found.off <= Math.max(length * 0.09, 8 / scale) ? found : null;
}

/** Snap on a wall: to its crossing with the ray, else to the line of a corner, else to a 5 cm grid along it. */
function onWall({ edge: [a, b], point }, ray, from, corners, pointer, near) {
  if (ray) {
    const at = crossing(from, add(from, ray.way), a, b);
    const met = at && add(from, times(ray.way, at[0]));
    if (met && dist(met, pointer) <= near * 1.6) return { point: roundPoint(met), kind: "wall", guides: [[from, met]] };
  }
  const upright = Math.abs(a[0] - b[0]) < 1e-6, level = Math.abs(a[1] - b[1]) < 1e-6;
  if (!upright && !level) return { point: roundPoint(point), kind: "wall", guides: [] };
  const axis = upright ? 1 : 0;
  const line = corners.find((c) => Math.abs(c[axis] - point[axis]) <= near / 2);
  const low = Math.min(a[axis], b[axis]), high = Math.max(a[axis], b[axis]);
  const goal = line ? line[axis] : Math.max(low, Math.min(high, Math.round(point[axis] / 0.05) * 0.05));
  const snapped = upright ? [a[0], goal] : [goal, a[1]];
  return { point: roundPoint(snapped), kind: "wall", guides: line ? [[line, snapped]] : [] };
}

/** Snap on a ray: to the line of a corner, else to a length of whole grid steps. */
function onRay({ way, along }, from, corners, edges, near, scale) {
  const crossings = corners.flatMap((c) => [
    { corner: c, at: crossing(from, add(from, way), c, add(c, [0, 1])) },
    { corner: c, at: crossing(from, add(from, way), c, add(c, [1, 0])) },
  ]).filter(({ at }) => at && Math.abs(at[0] - along) <= near / 2);
  const best = crossings.sort((a, b) => Math.abs(a.at[0] - along) - Math.abs(b.at[0] - along))[0];
  const grid = gridOf(scale);
  const point = roundPoint(add(from, times(way, best ? best.at[0] : Math.round(along / grid) * grid)));
  return { point, kind: "angle", guides: [[from, point], ...(best ? [[best.corner, point]] : [])] };
}
