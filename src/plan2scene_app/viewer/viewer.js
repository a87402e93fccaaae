"use strict";
// The viewer: starts the page, draws when something has changed, and handles events.

const HELP = {
  orbit: "Drag to turn, right-drag or Shift-drag to move, scroll to come nearer. Click a surface to read about it.",
  walk: "Click the floor to go there, or walk by W A S D or arrows; drag to look. Click a wall to read about it; the floor, with Shift.",
};
const REST = 200; // milliseconds after which a picture at rest is drawn at a higher resolution
const PACES = [1, 0.75, 0.5]; // resolutions of moving pictures, as shares of the page's pixels per side
const canvas = $("view");
const keys = new Set();
const seen = { ceilings: false, shells: true, level: null }; // level: the shown level's id, null for all
let renderer, scene, pending = false, lastTime = 0, resting = 0;
let marked = null; // id of the room that is marked in the list
let pace = 0, late = 0, early = 0;

function refresh() {
  if (pending || !renderer || renderer.xr.isPresenting) return;
  pending = true;
  requestAnimationFrame((time) => {
    pending = false;
    keepPace(time - lastTime);
    const moving = step(Math.min((time - lastTime) / 1000, 0.1));
    lastTime = time;
    if (eye.mode === "walk" && moving) markRoom(eye.room);
    draw(PACES[pace] * Math.max(1, window.devicePixelRatio || 1));
    clearTimeout(resting);
    if (moving || performance.now() - chosenAt < FLASH) refresh();
    else resting = setTimeout(() => draw(Math.max(2, window.devicePixelRatio || 1)), REST);
  });
}

function keepPace(gap) {
  // Lowers the resolution after three slow pictures in a row (under 30 a second), raises it after 60 fast ones.
  if (gap > 400) return; // the picture was at rest in between
  late = gap > 35 ? late + 1 : 0;
  early = gap < 18 ? early + 1 : 0;
  if (late < 3 && early < 60) return;
  pace = late ? Math.min(pace + 1, PACES.length - 1) : Math.max(pace - 1, 0);
  late = early = 0;
}

function draw(ratio) {
  // Draws one picture. Pictures at rest are drawn larger to smooth edges. Multisampling is not used: on
  // software renderers it lets the wall behind a corner show through.
  if (renderer.xr.isPresenting) return;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (renderer.getPixelRatio() !== ratio || canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio)) {
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
  }
  for (const part of parts) {
    const { kind } = part.extras;
    const level = eye.mode === "walk" || seen.level === null || part.level === null || part.level === seen.level;
    part.mesh.visible = level && (kind !== "ceiling" || seen.ceilings) && (kind !== "structure" || seen.shells);
    part.uniforms.glow.value = part === chosen ? 0.3 * Math.max(0, 1 - (performance.now() - chosenAt) / FLASH) : 0;
  }
  aim(canvas);
  drawMap();
  if (eye.mode === "walk" && seen.ceilings) hideUnseen();
  const outside = eye.mode === "orbit"; // inside, few parts are visible; they are drawn one by one, nearest first
  for (const part of parts) part.mesh.material.visible = !outside || !part.gathered || part === chosen || Boolean(part.painted);
  for (const { mesh, members } of gathered) mesh.visible = outside && members.some((part) => part.mesh.visible);
  renderer.render(scene, camera);
  label(canvas);
}

function markRoom(id) {
  const level = rooms.find((room) => room.id === id)?.level;
  if (seen.level !== null && level != null && level !== seen.level) setLevel(level); // after walking up or down the stairs
  if (eye.mode === "walk" && id !== marked) keepLink(id);
  marked = id;
  for (const room of rooms) room.button.setAttribute("aria-current", String(room.id === id));
}

function setLevel(id) {
  seen.level = id;
  for (const button of $("floors").children) button.setAttribute("aria-pressed", String(button.value === (id ?? "")));
  for (const room of rooms) room.button.parentElement.hidden = id !== null && room.level !== id;
  refresh();
}

function focus(room) {
  const { mode } = eye;
  stop();
  if (seen.level !== null && room.level !== seen.level) setLevel(room.level);
  if (mode === "walk") enter(room);
  else fit(parts.filter((part) => part.extras.room_id === room.id && part.extras.surface), 0.75, canvas, undefined, Math.min(orbit.getPolarAngle(), 0.52));
  markRoom(room.id);
  describe(room.floor);
  refresh();
}

function listRooms() {
  for (const room of rooms) {
    room.button = Object.assign(document.createElement("button"), { type: "button" });
    room.button.append(room.title, text("span", area(room.size, 1)));
    room.button.addEventListener("click", () => focus(room));
    const item = document.createElement("li");
    item.append(room.button);
    $("rooms").append(item);
  }
  $("floors").hidden = levels.length < 2;
  for (const level of levels.length < 2 ? [] : [{ id: "", name: "All" }, ...levels]) {
    const button = Object.assign(text("button", level.name), { type: "button", value: level.id });
    button.setAttribute("aria-pressed", String(level.id === ""));
    button.addEventListener("click", () => setLevel(level.id || null));
    $("floors").append(button);
  }
}

function setMode(mode) {
  stop();
  const current = rooms.find((room) => room.button.getAttribute("aria-current") === "true");
  if (mode !== eye.mode) $("ceilings").checked = seen.ceilings = mode === "walk";
  if (mode === "walk" && eye.mode !== "walk") eye.outside = camera.position.clone();
  if (mode === "orbit" && eye.mode === "walk") camera.position.copy(eye.outside);
  if (mode === "walk" && eye.mode !== "walk") enter(current || rooms.reduce((a, b) => (b.size > a.size ? b : a)));
  eye.mode = mode;
  eye.field = FIELDS.walk;
  orbit.enabled = mode === "orbit";
  if (mode === "orbit") orbit.update();
  $("orbit").setAttribute("aria-pressed", String(mode === "orbit"));
  $("walk").setAttribute("aria-pressed", String(mode === "walk"));
  document.body.classList.toggle("walking", mode === "walk");
  $("pad").hidden = mode !== "walk";
  $("help").textContent = HELP[mode];
  refresh();
}

function click(x, y, reads) {
  const photo = photoAt(x, y, canvas), hit = !tape.on && !photo && pick(x, y, canvas);
  if (tape.on) measure(x, y, canvas);
  else if (photo) flyTo(photo);
  else if (hit && eye.mode === "walk" && !reads && GROUND.has(hit.part.extras.kind)) goTo(hit.point);
  else {
    chosen = hit?.part || null;
    chosenAt = performance.now();
    describe(chosen);
  }
  refresh();
}

function listenToPointers() {
  const pointers = new Map();
  let travelled = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (!pointers.size) travelled = 0;
    pointers.set(event.pointerId, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const dx = event.clientX - last.clientX, dy = event.clientY - last.clientY;
    travelled += Math.abs(dx) + Math.abs(dy);
    pointers.set(event.pointerId, event);
    if (eye.mode === "walk" && travelled >= 5) { stop(); turnBy(dx, dy); refresh(); }
  });
  const release = (event) => {
    const held = pointers.delete(event.pointerId);
    if (held && event.type === "pointerup" && event.button === 0 && travelled < 5) click(event.clientX, event.clientY, event.shiftKey);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
}

function hold(key) {
  if (!keys.size) lastTime = performance.now();
  keys.add(key);
  refresh();
}

function listenToKeys() {
  const nearer = (factor) => {
    camera.position.sub(orbit.target).multiplyScalar(factor).add(orbit.target);
    orbit.update();
  };
  // Keys are handled for the whole page, so that walking by keys still works after a click on a button.
  document.addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase(), { tagName, type } = event.target;
    if (event.ctrlKey || event.metaKey || event.altKey || tagName === "SELECT" || type === "range") return;
    if (key === "+" || key === "=") nearer(0.9);
    else if (key === "-") nearer(1.1);
    else if (key === "m") setTape(!tape.on);
    else if (key === "escape") letGo();
    else if (/^([wasd]|arrow.*)$/.test(key)) hold(key);
    else return;
    event.preventDefault();
    refresh();
  });
  document.addEventListener("keyup", (event) => keys.delete(event.key.toLowerCase()));
  window.addEventListener("blur", () => keys.clear());
  for (const button of $("pad").children) {
    button.addEventListener("pointerdown", (event) => { button.setPointerCapture(event.pointerId); hold(button.value); });
    for (const end of ["pointerup", "pointercancel"]) button.addEventListener(end, () => keys.delete(button.value));
  }
}

function listen() {
  listenToPointers();
  listenToKeys();
  $("orbit").addEventListener("click", () => setMode("orbit"));
  $("walk").addEventListener("click", () => setMode("walk"));
  $("plan").addEventListener("click", () => { setMode("orbit"); fit(parts, 0.9, canvas, 0, 0); refresh(); });
  $("measure").addEventListener("click", () => setTape(!tape.on));
  for (const name of Object.keys(LOOKS)) $(name).addEventListener("click", () => setLook(name));
  for (const name of ["ceilings", "shells"]) $(name).addEventListener("change", (event) => { seen[name] = event.target.checked; refresh(); });
  $("tour").addEventListener("click", () => setTour(!tour));
  $("photos").addEventListener("click", () => flyTo(eye.photo ?? placed()[0]));
  $("photos").hidden = !placed().length;
  blend.addEventListener("input", showBlend);
  $("map").addEventListener("click", clickMap);
  $("full").hidden = !document.fullscreenEnabled;
  $("full").addEventListener("click", () => (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen()));
  $("headset").addEventListener("click", enterHeadset);
  $("shot").addEventListener("click", savePicture);
  $("tall").addEventListener("change", (event) => { eye.height = Number(event.target.value); refresh(); });
  $("unit").addEventListener("change", (event) => {
    feet = event.target.value === "feet";
    for (const room of rooms) room.button.lastChild.textContent = area(room.size, 1);
    if (tape.points.length === 2) stretch(); else if (chosen) describe(chosen);
    refresh();
  });
  $("fold").addEventListener("click", () => {
    const folded = document.body.classList.toggle("folded");
    $("fold").setAttribute("aria-expanded", String(!folded));
  });
  window.addEventListener("hashchange", openLink);
  $("shots").addEventListener("change", (event) => { frusta.visible = event.target.checked; refresh(); });
  new ResizeObserver(refresh).observe(canvas);
}

function savePicture() {
  draw(Math.max(2, window.devicePixelRatio || 1)); // the buffer stays valid until this task ends
  canvas.toBlob((blob) => {
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: `${document.querySelector("h1").textContent}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  });
}

function startRenderer() {
  try {
    renderer = new THREE.WebGLRenderer({ canvas, antialias: false, stencil: false });
  } catch {
    throw new Error("This browser has no WebGL 2. house.glb opens in any glTF program.");
  }
  renderer.setClearColor(0xf7f6f3, 1);
  renderer.setOpaqueSort(nearestFirst);
  const gl = renderer.getContext(), names = gl.getExtension("WEBGL_debug_renderer_info");
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  // Without a GPU, anisotropic filtering of floors seen at a flat angle would take most of the time.
  return /swiftshader|llvmpipe|software|basic render/i.test(name) ? 1 : renderer.capabilities.getMaxAnisotropy();
}

async function start() {
  const sharpness = startRenderer();
  const house = await readHouse();
  parts.forEach((part) => paint(part, Math.min(4, sharpness)));
  scene = new THREE.Scene();
  scene.add(house, drawFrusta(), ...makeTape());
  stretch();
  hangLamps();
  gather(scene);
  whole = boxOf(parts).getBoundingSphere(whole);
  startOrbit(canvas);
  listRooms();
  listen();
  setMode("orbit");
  setLook("day");
  fit(parts, 0.92, canvas, 0.42, 0.62);
  if (innerWidth <= 600) $("fold").click();
  openLink();
  offerHeadset();
  draw(1);
  $("message").textContent = "";
  document.body.dataset.ready = performance.now().toFixed(0);
}

start().catch((error) => { $("message").textContent = error.message; console.error(error); });
