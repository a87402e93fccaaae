"use strict";
// The eye: orbit around the house, or walk in it; what it sees sharply.

const FIELDS = { orbit: 32, walk: 62 }; // vertical fields of view, degrees
const EYE = 1.6; // metres above the floor
const eye = { mode: "orbit", feet: new THREE.Vector3(), yaw: 0, pitch: 0, field: FIELDS.walk };
const camera = new THREE.PerspectiveCamera(FIELDS.orbit, 1, 0.05, 100);
let orbit; // three's controls
let whole = new THREE.Sphere(new THREE.Vector3(), 1); // around everything

const forward = () => new THREE.Vector3(
  Math.sin(eye.yaw) * Math.cos(eye.pitch), Math.sin(eye.pitch), Math.cos(eye.yaw) * Math.cos(eye.pitch));

function startOrbit(canvas) {
  orbit = new THREE.OrbitControls(camera, canvas);
  Object.assign(orbit, { minDistance: 0.5, maxDistance: 120, maxPolarAngle: 1.55, zoomSpeed: 1.2 });
  orbit.addEventListener("change", refresh);
}

function freeWidth(canvas) {
  // Left margin that the panel covers, in CSS pixels; 0 where it would leave too little.
  const panel = $("panel").getBoundingClientRect();
  return panel.width < 0.4 * canvas.clientWidth ? panel.right : 0;
}

function aim(canvas) {
  // Place, lens and depth range of the camera for the next picture.
  const width = canvas.clientWidth || 1, height = canvas.clientHeight || 1;
  if (eye.mode === "walk") {
    camera.position.copy(eye.feet).add(new THREE.Vector3(0, EYE, 0));
    camera.lookAt(camera.position.clone().add(forward()));
    camera.clearViewOffset();
  } else {
    camera.setViewOffset(width, height, -freeWidth(canvas) / 2, 0, width, height);
  }
  camera.fov = eye.mode === "walk" ? eye.field : FIELDS.orbit;
  camera.aspect = width / height;
  // As tight as the house allows: rooms' walls stand back to back.
  const away = whole.center.clone().sub(camera.position).dot(camera.getWorldDirection(new THREE.Vector3()));
  camera.near = Math.max(0.05, away - whole.radius);
  camera.far = Math.max(camera.near + 1, away + whole.radius);
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}

function fit(list, share, canvas, azimuth = orbit.getAzimuthalAngle(), polar = orbit.getPolarAngle()) {
  // Looks at the middle of some parts from where their box fills `share` of the free picture.
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
  // Stands in a room and looks along its longer side, where there is more of it.
  const box = boxOf([room.floor]), centre = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3());
  eye.feet.copy(room.inside);
  const across = centre.x >= room.inside.x ? Math.PI / 2 : -Math.PI / 2, along = centre.z >= room.inside.z ? 0 : Math.PI;
  Object.assign(eye, { yaw: size.x > size.z ? across : along, pitch: -0.08, field: FIELDS.walk });
}

function turnBy(dx, dy) {
  eye.yaw += dx * 0.004;
  eye.pitch = Math.max(-1.4, Math.min(1.4, eye.pitch + dy * 0.004));
}

function standAt(photo) {
  // Sees what a located photo sees, as wide as it; its roll is left out.
  const [x, y, z] = photo.position, ahead = photo.rotation[2];
  eye.feet.set(x, y - EYE, z);
  eye.yaw = Math.atan2(ahead[0], ahead[2]);
  eye.pitch = Math.asin(Math.max(-1, Math.min(1, ahead[1])));
  eye.field = (2 * Math.atan(photo.height / 2 / photo.focal_px) * 180) / Math.PI;
}
