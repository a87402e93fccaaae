"use strict";
// The eye: it orbits around the house or walks in it; the camera with its depth range.

const FIELDS = { orbit: 32, walk: 62 }; // vertical fields of view, degrees
const eye = { mode: "orbit", height: 1.6, feet: new THREE.Vector3(), yaw: 0, pitch: 0, field: FIELDS.walk, photo: null };
const camera = new THREE.PerspectiveCamera(FIELDS.orbit, 1, 0.05, 100);
let orbit; // the OrbitControls of three.js
let whole = new THREE.Sphere(new THREE.Vector3(), 1); // bounding sphere of the house

const forward = () => new THREE.Vector3(
  Math.sin(eye.yaw) * Math.cos(eye.pitch), Math.sin(eye.pitch), Math.cos(eye.yaw) * Math.cos(eye.pitch));

function startOrbit(canvas) {
  orbit = new THREE.OrbitControls(camera, canvas);
  Object.assign(orbit, { minDistance: 0.5, maxDistance: 120, maxPolarAngle: 1.55, zoomSpeed: 1.2 });
  orbit.addEventListener("change", refresh);
}

function freeWidth(canvas) {
  // Left margin that the panel covers, in CSS pixels; 0 if the panel is folded or leaves too little space.
  if (document.body.classList.contains("folded")) return 0;
  const panel = $("panel").getBoundingClientRect();
  return panel.width < 0.4 * canvas.clientWidth ? panel.right : 0;
}

function aim(canvas) {
  // Sets position, field of view and depth range of the camera for the next picture.
  const width = canvas.clientWidth || 1, height = canvas.clientHeight || 1;
  if (eye.mode === "walk") {
    const [, down, ahead] = eye.photo?.rotation ?? [];
    camera.position.copy(eye.feet).setY(eye.feet.y + eye.height);
    camera.up.set(...(down ? down.map((v) => -v) : [0, 1, 0]));
    camera.lookAt(camera.position.clone().add(ahead ? new THREE.Vector3(...ahead) : forward()));
    if (eye.photo) eye.field = fieldOf(eye.photo);
    camera.clearViewOffset();
  } else {
    camera.up.set(0, 1, 0);
    camera.setViewOffset(width, height, -freeWidth(canvas) / 2, 0, width, height);
  }
  camera.fov = eye.mode === "walk" ? eye.field : FIELDS.orbit;
  camera.aspect = width / height;
  // A depth range as small as possible, so that the walls of neighbouring rooms, back to back, do not flicker.
  const away = whole.center.clone().sub(camera.position).dot(camera.getWorldDirection(new THREE.Vector3()));
  camera.near = Math.max(0.05, away - whole.radius);
  camera.far = Math.max(camera.near + 1, away + whole.radius);
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}

function fit(list, share, canvas, azimuth = orbit.getAzimuthalAngle(), polar = orbit.getPolarAngle()) {
  // Looks at the middle of some parts, from a distance at which their box fills `share` of the free picture.
  const box = boxOf(list), centre = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3());
  const back = new THREE.Vector3().setFromSphericalCoords(1, polar, azimuth);
  const right = new THREE.Vector3(Math.cos(azimuth), 0, -Math.sin(azimuth)), up = back.clone().cross(right);
  const tangent = Math.tan((FIELDS.orbit * Math.PI) / 360);
  const wide = (canvas.clientWidth - freeWidth(canvas)) / (canvas.clientHeight || 1) || 1;
  let distance = 1.5 * size.length();
  for (let pass = 0; pass < 6; pass++) {
    let spread = 0;
    for (let k = 0; k < 8; k++) {
      const corner = new THREE.Vector3(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5).multiply(size);
      const reach = Math.max(0.1, distance - corner.dot(back)) * tangent;
      spread = Math.max(spread, Math.abs(corner.dot(right)) / reach / wide, Math.abs(corner.dot(up)) / reach);
    }
    distance *= spread / share;
  }
  orbit.target.copy(centre);
  camera.position.copy(centre).addScaledVector(back, distance);
  orbit.update();
}

function enter(room) {
  // Places the eye in a room with its back to a wall, so that it sees farthest ahead.
  if (!barriers) buildWorld();
  const sight = (from, yaw) => sightIn(room, from, yaw);
  let best = { ahead: -1 };
  for (let yaw = 0; yaw < 6.28; yaw += Math.PI / 12) {
    eye.feet.copy(room.inside);
    eye.room = room.id;
    const far = Math.min(6, Math.max(0, sight(eye.feet, yaw + Math.PI) - BODY - 0.05));
    walkBy(-far * Math.sin(yaw), -far * Math.cos(yaw));
    if (eye.room !== room.id) continue;
    const ahead = [-0.5, -0.25, 0, 0.25, 0.5].reduce((sum, turn) => sum + sight(eye.feet, yaw + turn), 0);
    if (ahead > best.ahead + 0.05) best = { ahead, yaw, feet: eye.feet.clone() };
  }
  eye.feet.copy(best.feet ?? room.inside);
  Object.assign(eye, { room: room.id, yaw: best.yaw ?? 0, pitch: best.ahead < 10 ? -0.3 : -0.08, field: FIELDS.walk, photo: null });
}

function sightIn(room, from, yaw) {
  // Metres from a point at eye level to the first wall, door or window of a room, or to its bounding box.
  const around = room.around ??= parts.filter(({ extras }) => extras.room_id === room.id && /^(wall|door|window|glass)$/.test(extras.kind)).map((part) => part.mesh);
  const way = new THREE.Vector3(Math.sin(yaw), 0, Math.cos(yaw)), { min, max } = room.floor.box;
  const ray = new THREE.Raycaster(from.clone().setY(from.y + eye.height), way);
  const out = Math.min(...["x", "z"].map((axis) => (way[axis] ? ((way[axis] > 0 ? max : min)[axis] - from[axis]) / way[axis] : Infinity)));
  return Math.min(out, ray.intersectObjects(around, false)[0]?.distance ?? Infinity);
}

function turnBy(dx, dy) {
  eye.yaw += dx * 0.004;
  eye.pitch = Math.max(-1.4, Math.min(1.4, eye.pitch + dy * 0.004));
}
