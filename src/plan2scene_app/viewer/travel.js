"use strict";
// Automatic moves through the house: glides to a place or a photo, a tour, links to a room.

const GLIDE = 0.7; // seconds
const LINGER = 6; // seconds that a tour stays in a room
const calm = matchMedia("(prefers-reduced-motion: reduce)");
const blending = $("blending"), blend = $("blend"); // elements that are moved into a photo's card
let glide = null, tour = null;

const turnTo = (from, to) => from + Math.atan2(Math.sin(to - from), Math.cos(to - from));

function glideTo(goal, arrived = () => {}) {
  // Moves the eye smoothly to {feet, yaw, pitch, field}; missing values stay.
  const from = { feet: eye.feet.clone(), yaw: eye.yaw, pitch: eye.pitch, field: eye.field };
  const to = { ...from, ...goal };
  to.yaw = turnTo(from.yaw, to.yaw);
  glide = { from, to, arrived, start: performance.now() };
  if (calm.matches) moveGlide(Infinity);
  lastTime = performance.now();
  refresh();
}

function moveGlide(now = performance.now()) {
  // Returns whether the glide still goes on.
  if (!glide) return false;
  const { from, to, arrived, start } = glide, share = Math.min(1, (now - start) / 1000 / GLIDE);
  const eased = share * share * (3 - 2 * share), mix = (key) => from[key] + (to[key] - from[key]) * eased;
  eye.feet.lerpVectors(from.feet, to.feet, eased);
  Object.assign(eye, { yaw: mix("yaw"), pitch: mix("pitch"), field: mix("field") });
  if (share < 1) return true;
  glide = null;
  arrived();
  return false;
}

function stop() {
  // Ends all automatic moves, when the user walks, turns or chooses something.
  glide = tour = null;
  $("tour").setAttribute("aria-pressed", "false");
  if (eye.photo) leavePhoto();
}

function goTo(point) {
  // Glides to a point of the floor, or a little before it if an obstacle is there.
  if (!barriers) buildWorld();
  const feet = point.clone(), back = eye.feet.clone().sub(point).setY(0);
  back.normalize().multiplyScalar(0.1);
  for (let k = 0; k < 8 && barriers.capsuleIntersect(bodyAt(feet)); k++) feet.add(back);
  const ground = groundAt(feet.x, feet.z, feet.y);
  stop();
  describe(null);
  glideTo({ feet, field: FIELDS.walk }, () => markRoom(eye.room = ground?.part.extras.room_id ?? eye.room));
}

// Photos: the eye flies to a photo's camera, takes its field of view, and the photo is blended over the house.

const placed = () => facts.photos.filter((photo) => photo.position);

function poseOf(photo) {
  const [x, y, z] = photo.position, ahead = photo.rotation[2];
  return { feet: new THREE.Vector3(x, y - eye.height, z), yaw: Math.atan2(ahead[0], ahead[2]), pitch: Math.asin(Math.max(-1, Math.min(1, ahead[1]))), field: fieldOf(photo) };
}

function fieldOf(photo) {
  // Vertical field of view, degrees, in which the whole photo is visible.
  const wide = Math.max(1, photo.width / photo.height / (canvas.clientWidth / canvas.clientHeight || 1));
  return (2 * Math.atan((wide * photo.height) / 2 / photo.focal_px) * 180) / Math.PI;
}

function flyTo(photo) {
  const above = eye.mode === "orbit" && { feet: camera.position.clone().setY(camera.position.y - eye.height), ahead: camera.getWorldDirection(new THREE.Vector3()) };
  setMode("walk");
  stop();
  if (above) Object.assign(eye, { feet: above.feet, yaw: Math.atan2(above.ahead.x, above.ahead.z), pitch: Math.asin(above.ahead.y), field: FIELDS.orbit });
  describePhoto(photo);
  glideTo(poseOf(photo), () => { eye.photo = photo; eye.room = photo.room_id; markRoom(photo.room_id); showBlend(); });
}

function showBlend() {
  const { photo } = eye;
  $("photo").hidden = !photo?.image;
  if (photo?.image) { $("photo").src = photo.image; $("photo").style.opacity = blend.value / 100; }
}

function leavePhoto() {
  eye.photo = null;
  eye.field = FIELDS.walk;
  showBlend();
}

function nextPhoto(photo, by) {
  const all = placed();
  flyTo(all[(all.indexOf(photo) + by + all.length) % all.length]);
}

// The tour visits each room in turn and looks around in it.

function setTour(on) {
  stop();
  if (!on) return;
  setMode("walk");
  tour = { number: -1, since: -Infinity };
  $("tour").setAttribute("aria-pressed", "true");
  refresh();
}

function moveTour(seconds) {
  if (!tour) return false;
  if (performance.now() - tour.since > LINGER * 1000) {
    tour.number = (tour.number + 1) % rooms.length;
    tour.since = performance.now();
    enter(rooms[tour.number]);
    eye.room = rooms[tour.number].id;
  } else if (!calm.matches) eye.yaw += 0.2 * seconds;
  return true;
}

// Links: `#room=kitchen` opens the page in that room; `#from=` with six coordinates in metres (eye and
// target) opens it with a view from outside.

function openLink() {
  const given = new URLSearchParams(location.hash.slice(1)), room = rooms.find(({ id }) => id === given.get("room"));
  const from = given.get("from")?.split(",").map(Number) ?? [];
  if (room) { setMode("walk"); focus(room); }
  else if (from.length === 6 && from.every(Number.isFinite)) {
    setMode("orbit");
    camera.position.fromArray(from);
    orbit.target.fromArray(from, 3);
    orbit.update();
  }
}

function placeNow() {
  const outside = [...camera.position.toArray(), ...orbit.target.toArray()].map((value) => value.toFixed(2));
  return new URLSearchParams(eye.mode === "walk" ? { room: eye.room } : { from: outside.join() }).toString();
}

function keepLink(id) {
  try { history.replaceState(null, "", `#${new URLSearchParams({ room: id })}`); } catch { /* a frame without a URL */ }
}
