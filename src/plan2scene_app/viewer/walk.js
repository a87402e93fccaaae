"use strict";
// Walking: a capsule moves over floors and stairs; walls, windows, shut doors and objects stop it (the
// Octree of three.js). Inner doors do not stop it.

const BODY = 0.22; // metres: radius of the capsule
const TALL = 1.6; // metres: upper end of the capsule's axis
const KNEE = 0.45; // metres: lower end of the capsule; lower things do not stop it, except too high ground
const STEP = 0.3; // metres: the highest step up; a step down may be twice as high
const STRIDE = 0.04; // metres between two tests for collisions
const GROUND = new Set(["floor", "threshold", "stairs"]);
const STOPS = new Set(["wall", "structure", "window", "glass", "railing", "object", "stairs"]);
let barriers = null, grounds = null;

const stops = ({ extras }) => STOPS.has(extras.kind) || (extras.kind === "door" && !extras.leads_to);

function buildWorld() {
  barriers = new THREE.Octree();
  grounds = [];
  for (const part of parts) {
    for (const { a, b, c } of trianglesOf(part.mesh)) {
      const copy = new THREE.Triangle(a.clone(), b.clone(), c.clone());
      const level = copy.getNormal(new THREE.Vector3()).y > 0.7;
      if (GROUND.has(part.extras.kind) && level) grounds.push({ part, triangle: copy, box: new THREE.Box3().setFromPoints([a, b, c]) });
      else if (stops(part)) {
        barriers.addTriangle(copy);
        // A pane has one side in the mesh; add the other.
        if (part.glass) barriers.addTriangle(new THREE.Triangle(copy.a, copy.c, copy.b));
      }
    }
  }
  barriers.build();
}

function groundAt(x, z, feet) {
  // The highest ground within a step of the feet at a point or close around it: {y, part} or null.
  for (const [dx, dz] of [[0, 0], [0.06, 0], [-0.06, 0], [0, 0.06], [0, -0.06]]) {
    const point = new THREE.Vector3();
    let best = null;
    for (const { part, triangle, box } of grounds) {
      if (x + dx < box.min.x - 1e-6 || x + dx > box.max.x + 1e-6 || z + dz < box.min.z - 1e-6 || z + dz > box.max.z + 1e-6) continue;
      const y = triangle.a.y; // ground triangles are horizontal
      if (y > feet + STEP || y < feet - 2 * STEP || (best && y <= best.y)) continue;
      if (triangle.containsPoint(point.set(x + dx, y, z + dz))) best = { y, part };
    }
    if (best) return best;
  }
  return null;
}

const bodyAt = ({ x, y, z }) => new THREE.Capsule(new THREE.Vector3(x, y + KNEE + BODY, z), new THREE.Vector3(x, y + TALL, z), BODY);

function stride(dx, dz) {
  // Makes one short move, sliding along obstacles; returns whether it succeeded.
  const place = eye.feet.clone().add(new THREE.Vector3(dx, 0, dz));
  for (let pass = 0; pass < 4; pass++) {
    const hit = barriers.capsuleIntersect(bodyAt(place));
    if (!hit) break;
    const push = new THREE.Vector3(hit.normal.x, 0, hit.normal.z);
    if (push.lengthSq() < 1e-6) break;
    place.addScaledVector(push.normalize(), hit.depth + 1e-4);
    if (pass === 3) return false;
  }
  if (place.distanceTo(eye.feet) > 2 * STRIDE) return false;
  const ground = groundAt(place.x, place.z, eye.feet.y);
  if (!ground) return false;
  eye.feet.set(place.x, ground.y, place.z);
  eye.room = ground.part.extras.room_id;
  return true;
}

function walkBy(dx, dz) {
  // Moves by (dx, dz) metres in the plan, as far as nothing blocks the way.
  if (!barriers) buildWorld();
  const count = Math.max(1, Math.ceil(Math.hypot(dx, dz) / STRIDE));
  for (let k = 0; k < count; k++) {
    if (!stride(dx / count, dz / count) && !stride(dx / count, 0) && !stride(0, dz / count)) break;
  }
}

function step(seconds) {
  // Walks (or moves the orbit's target) with the pressed keys; returns whether anything is moving.
  const held = (...names) => (names.some((name) => keys.has(name)) ? 1 : 0);
  const along = held("w", "arrowup") - held("s", "arrowdown"), across = held("d") - held("a");
  const turn = held("arrowright") - held("arrowleft");
  const gliding = moveGlide();
  if (!along && !across && !turn) return moveTour(seconds) || gliding || keys.size > 0;
  stop();
  if (eye.mode === "walk") {
    eye.yaw -= turn * 1.6 * seconds;
    const far = 1.8 * seconds, [sin, cos] = [Math.sin(eye.yaw), Math.cos(eye.yaw)];
    if (along || across) walkBy(far * (along * sin - across * cos), far * (along * cos + across * sin));
    return true;
  }
  const away = camera.position.clone().sub(orbit.target), far = 0.5 * away.length() * seconds;
  const angle = orbit.getAzimuthalAngle(), [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  orbit.target.add(new THREE.Vector3(far * (across * cos - along * sin), 0, -far * (across * sin + along * cos)));
  away.applyAxisAngle(new THREE.Vector3(0, 1, 0), turn * 1.2 * seconds);
  camera.position.copy(orbit.target).add(away);
  orbit.update();
  return true;
}
