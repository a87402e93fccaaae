"use strict";
// Visibility: from inside a room, one sees that room, and other rooms only through its openings.

const OPENINGS = new Set(["door", "passage", "window", "stairs"]); // stairs fill the opening in the floor
const WHOLE = [-1, -1, 1, 1]; // the whole picture: left, bottom, right, top
let shut = null; // map of rooms that are closed by walls all around: id to the parts of its openings

function findShut() {
  // A room is closed if its walls together are as long as its outline.
  shut = new Map();
  for (const room of rooms) {
    if (!room.floor) continue;
    const walls = parts.filter(({ extras }) => extras.room_id === room.id && extras.kind === "wall");
    const length = walls.reduce((sum, { box }) => sum + Math.hypot(box.max.x - box.min.x, box.max.z - box.min.z), 0);
    if (length < outlineOf(room.floor) - 0.05) continue;
    shut.set(room.id, parts.filter(({ extras }) => OPENINGS.has(extras.kind) && (extras.room_id === room.id || extras.leads_to === room.id)));
  }
}

function outlineOf(floor) {
  // Length of a floor's outline: of all edges that belong to one triangle only.
  const edges = new Map(), name = ({ x, z }) => `${x.toFixed(3)} ${z.toFixed(3)}`;
  for (const { a, b, c } of trianglesOf(floor.mesh)) {
    for (const [p, q] of [[a, b], [b, c], [c, a]]) {
      const key = [name(p), name(q)].sort().join();
      edges.set(key, edges.has(key) ? 0 : p.distanceTo(q));
    }
  }
  return [...edges.values()].reduce((sum, length) => sum + length, 0);
}

function frameOf(box) {
  // The part of the picture that a box may cover: the whole picture if the box reaches behind the eye,
  // nothing if all of it is behind.
  const frame = [Infinity, Infinity, -Infinity, -Infinity], corner = new THREE.Vector4();
  const { min, max } = box;
  let behind = 0;
  for (let k = 0; k < 8; k++) {
    corner.set(k & 1 ? min.x : max.x, k & 2 ? min.y : max.y, k & 4 ? min.z : max.z, 1);
    corner.applyMatrix4(camera.matrixWorldInverse).applyMatrix4(camera.projectionMatrix);
    if (corner.w <= camera.near) { behind += 1; continue; }
    const x = corner.x / corner.w, y = corner.y / corner.w;
    frame[0] = Math.min(frame[0], x); frame[2] = Math.max(frame[2], x);
    frame[1] = Math.min(frame[1], y); frame[3] = Math.max(frame[3], y);
  }
  return behind % 8 ? WHOLE : frame;
}

const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];

function hideUnseen() {
  // Call it after aim(). Hides parts that cannot be seen through an opening of the eye's room.
  if (!shut) findShut();
  const room = rooms.find((entry) => camera.position.y > entry.inside.y && camera.position.y < entry.inside.y + entry.height && over(entry, camera.position));
  if (!room || !shut.has(room.id)) return;
  const frames = shut.get(room.id).map((part) => frameOf(part.box)).filter((frame) => meet(frame, WHOLE));
  for (const part of parts) {
    if (!part.mesh.visible || part.extras.room_id === room.id || part.extras.leads_to === room.id) continue;
    const own = frameOf(part.box);
    part.mesh.visible = frames.some((frame) => meet(frame, own));
  }
}

function nearestFirst(a, b) {
  // Draws near parts first, so that the pixels of hidden parts are not shaded.
  return a.groupOrder - b.groupOrder || a.renderOrder - b.renderOrder || away(a.object) - away(b.object);
}

function away(mesh) {
  const { frame } = renderer.info.render, { part } = mesh;
  if (!part) return Number.MAX_VALUE; // lines drawn over the house come last
  if (part.frame !== frame) Object.assign(part, { frame, away: part.box.distanceToPoint(camera.position) });
  return part.away;
}
