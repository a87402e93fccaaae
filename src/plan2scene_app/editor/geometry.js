// Plane geometry of plans. Points are [x, z] in metres, x right and z down; a ring is a list of
// points, closed, the first not repeated; a polygon is a list of rings, the first its outline.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1]];
export const times = (a, k) => [a[0] * k, a[1] * k];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1];
export const cross = (a, b) => a[0] * b[1] - a[1] * b[0];
export const dist = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
export const mid = (a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
export const unit = (a) => times(a, 1 / (Math.hypot(a[0], a[1]) || 1));
/** A coordinate rounded to whole millimetres, as in files. */
export const round = (v) => Math.round(v * 1000) / 1000 + 0;
export const roundPoint = (p) => p.map(round);

export const edgesOf = (ring) => ring.map((p, k) => [p, ring[(k + 1) % ring.length]]);
export const ringsOf = (room) => [room.polygon, ...(room.holes ?? [])];

/** The point of segment ab nearest to p, its share t of the way (0..1) and its distance. */
export function nearestOn(a, b, p) {
  const way = sub(b, a);
  const t = Math.max(0, Math.min(1, dot(sub(p, a), way) / (dot(way, way) || 1)));
  const point = add(a, times(way, t));
  return { point, t, distance: dist(point, p) };
}

/** Signed area of a ring; the sign tells the direction of its points. */
export function signedArea(ring) {
  let sum = 0;
  for (const [a, b] of edgesOf(ring)) sum += cross(a, b);
  return sum / 2;
}

export const polygonArea = (rings) =>
  rings.reduce((sum, ring, k) => sum + (k ? -1 : 1) * Math.abs(signedArea(ring)), 0);

/** Whether a point lies in a polygon (even-odd over all rings). */
export function inside(rings, [x, z]) {
  let odd = false;
  for (const ring of rings)
    for (const [a, b] of edgesOf(ring))
      if (a[1] > z !== b[1] > z && x < a[0] + ((z - a[1]) / (b[1] - a[1])) * (b[0] - a[0])) odd = !odd;
  return odd;
}

/** Crossing of the lines ab and cd as [t, u] (0 at a and c, 1 at b and d); null if they are parallel. */
export function crossing(a, b, c, d) {
  const r = sub(b, a), s = sub(d, c);
  const det = cross(r, s);
  if (Math.abs(det) < 1e-12 * (Math.hypot(...r) * Math.hypot(...s) + 1e-300)) return null;
  return [cross(sub(c, a), s) / det, cross(sub(c, a), r) / det];
}

const between = (v, low, high) => v >= low && v <= high;

/** Whether two segments have a point in common. */
export function touch(a, b, c, d) {
  const at = crossing(a, b, c, d);
  if (at) return between(at[0], 0, 1) && between(at[1], 0, 1);
  return [[a, b, c], [a, b, d], [c, d, a], [c, d, b]].some(([p, q, r]) => nearestOn(p, q, r).distance < 1e-12);
}

/** A point where a polygon's outline meets itself; null if there is none. */
export function selfCrossing(rings) {
  const edges = rings.flatMap((ring, r) => edgesOf(ring).map((e, k) => ({ e, r, k, n: ring.length })));
  for (let i = 0; i < edges.length; i++)
    for (let j = i + 1; j < edges.length; j++) {
      const one = edges[i], two = edges[j];
      const next = one.r === two.r && (two.k === one.k + 1 || (one.k === 0 && two.k === two.n - 1));
      if (next) {
        const [tip, p, q] = two.k === one.k + 1 ? [one.e[1], one.e[0], two.e[1]] : [one.e[0], one.e[1], two.e[0]];
        const u = sub(p, tip), v = sub(q, tip);
        if (Math.abs(cross(u, v)) < 1e-12 && dot(u, v) > 0) return tip;
      } else if (touch(...one.e, ...two.e)) return mid(...one.e);
    }
  for (const hole of rings.slice(1)) if (!inside([rings[0]], hole[0])) return hole[0];
  return null;
}

/** Area of the intersection of two polygons: between the z of corners and crossings, widths are linear in z. */
export function sharedArea(one, two) {
  const edges = [...one, ...two].flatMap(edgesOf);
  const heights = edges.map(([a]) => a[1]);
  for (const [a, b] of one.flatMap(edgesOf))
    for (const [c, d] of two.flatMap(edgesOf)) {
      const at = crossing(a, b, c, d);
      if (at && between(at[0], 0, 1) && between(at[1], 0, 1)) heights.push(a[1] + at[0] * (b[1] - a[1]));
    }
  heights.sort((a, b) => a - b);
  let area = 0;
  for (let k = 1; k < heights.length; k++) {
    const low = heights[k - 1], high = heights[k];
    if (high - low < 1e-9) continue;
    const first = crossingsAt(one, (low + high) / 2), second = crossingsAt(two, (low + high) / 2);
    for (let i = 0; i + 1 < first.length; i += 2)
      for (let j = 0; j + 1 < second.length; j += 2)
        area += (high - low) * Math.max(0, Math.min(first[i + 1], second[j + 1]) - Math.max(first[i], second[j]));
  }
  return area;
}

function crossingsAt(rings, z) {
  const found = [];
  for (const ring of rings)
    for (const [a, b] of edgesOf(ring))
      if (a[1] > z !== b[1] > z) found.push(a[0] + ((z - a[1]) / (b[1] - a[1])) * (b[0] - a[0]));
  return found.sort((a, b) => a - b);
}

/** Distance between two polygons; 0 where they touch or overlap. */
export function polygonDistance(one, two) {
  if (inside(one, two[0][0]) || inside(two, one[0][0])) return 0;
  let best = Infinity;
  for (const [a, b] of one.flatMap(edgesOf))
    for (const [c, d] of two.flatMap(edgesOf)) {
      if (touch(a, b, c, d)) return 0;
      best = Math.min(best, nearestOn(a, b, c).distance, nearestOn(a, b, d).distance,
        nearestOn(c, d, a).distance, nearestOn(c, d, b).distance);
    }
  return best;
}

/** A point well inside a polygon for its label: the middle of its widest horizontal stretch. */
export function labelPoint(rings) {
  const zs = rings[0].map((p) => p[1]);
  const low = Math.min(...zs), high = Math.max(...zs);
  let best = { score: -1, point: rings[0][0] };
  for (let k = 1; k < 16; k++) {
    const z = low + ((high - low) * k) / 16;
    const xs = crossingsAt(rings, z + 1e-7);
    for (let i = 0; i + 1 < xs.length; i += 2) {
      const score = (xs[i + 1] - xs[i]) * (1 - 0.5 * Math.abs(k / 8 - 1));
      if (score > best.score + 1e-9) best = { score, point: [(xs[i] + xs[i + 1]) / 2, z] };
    }
  }
  return best.point;
}

export function boundsOf(points) {
  const xs = points.map((p) => p[0]), zs = points.map((p) => p[1]);
  return { low: [Math.min(...xs), Math.min(...zs)], high: [Math.max(...xs), Math.max(...zs)] };
}
