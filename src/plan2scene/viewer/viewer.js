"use strict";
// The viewer: WebGL 2, orbit and walk cameras, rooms by name, what a clicked surface is.

const FLASH = 900; // milliseconds that a clicked surface glows
const EYE = 1.6; // metres above the floor when walking
const FIELDS = { orbit: (32 * Math.PI) / 180, walk: (62 * Math.PI) / 180 }; // vertical fields of view
const HELP = {
  orbit: "Drag to turn, right-drag or Shift-drag to move, scroll to come nearer. Click a surface to read about it.",
  walk: "W A S D or arrows to walk, drag to look. Click a surface to read about it.",
};

const $ = (id) => document.getElementById(id);
const canvas = $("view");
let gl, program, uniforms, parts = [], textures = [], rooms = [], chosen = null, chosenAt = -Infinity;
const show = { ceilings: false, shells: true };
const eye = { mode: "orbit", target: [0, 0, 0], distance: 10, azimuth: 0.42, elevation: 0.95, position: [0, EYE, 0], yaw: 0, pitch: 0 };
const keys = new Set();
let house = { centre: [0, 0, 0], radius: 1 }; // a ball around everything
let pending = false, lastTime = 0;

function refresh() {
  if (pending) return;
  pending = true;
  requestAnimationFrame((time) => {
    pending = false;
    const moving = step(Math.min((time - lastTime) / 1000, 0.1));
    lastTime = time;
    draw();
    if (moving || performance.now() - chosenAt < FLASH) refresh();
  });
}

function pick(x, y) {
  // The nearest shown triangle that faces the eye under a point of the canvas (CSS pixels).
  const { position, right, up, forward } = frame();
  const box = canvas.getBoundingClientRect();
  const sx = ((x - box.left) / box.width) * 2 - 1 - shift(), sy = 1 - ((y - box.top) / box.height) * 2;
  const ray = unit(add(add(forward, right, sx * tangent() * (box.width / box.height)), up, sy * tangent()));
  let best = Infinity, found = null;
  for (const part of parts) {
    if (!shown(part) || part.glass) continue;
    const p = part.position, corner = (i) => [p[3 * i], p[3 * i + 1], p[3 * i + 2]];
    for (let k = 0; k < part.index.length; k += 3) {
      const a = corner(part.index[k]), ab = add(corner(part.index[k + 1]), a, -1), ac = add(corner(part.index[k + 2]), a, -1);
      const h = cross(ray, ac), det = dot(ab, h);
      if (det < 1e-12 && !(twoSided(part) && det < -1e-12)) continue;
      const s = add(position, a, -1), u = dot(s, h) / det, q = cross(s, ab), v = dot(ray, q) / det, t = dot(ac, q) / det;
      if (u >= 0 && v >= 0 && u + v <= 1 && t > 0.01 && t < best) { best = t; found = part; }
    }
  }
  return found;
}

function areaOf(part) {
  let sum = 0;
  const p = part.position, corner = (i) => [p[3 * i], p[3 * i + 1], p[3 * i + 2]];
  for (let k = 0; k < part.index.length; k += 3) {
    const a = corner(part.index[k]);
    sum += Math.hypot(...cross(add(corner(part.index[k + 1]), a, -1), add(corner(part.index[k + 2]), a, -1))) / 2;
  }
  return sum;
}

function describe(part) {
  const info = $("info");
  info.hidden = !part;
  info.replaceChildren();
  if (!part) return;
  const { extras } = part;
  const room = rooms.find((r) => r.id === extras.room_id);
  const rows = [["Room", room ? room.title : null], ["Part", extras.wall_id && extras.surface ? `wall ${extras.wall_id}` : null],
    ["Leads to", extras.leads_to ? (rooms.find((r) => r.id === extras.leads_to) || {}).title : null],
    ["Area", extras.surface ? `${areaOf(part).toFixed(2)} m\u00b2` : null],
    ["Substance", extras.substance], ["Texture tile", extras.size_m ? `${extras.size_m.toFixed(2)} m` : null],
    ["Photos", extras.observed === undefined ? null : extras.observed ? "observed" : "none: predicted"]];
  const title = document.createElement("h2");
  title.textContent = (extras.kind === "structure" ? "outer wall" : extras.kind || part.name).replace(/^./, (c) => c.toUpperCase());
  const list = document.createElement("dl");
  for (const [name, value] of rows) {
    if (!value) continue;
    list.append(Object.assign(document.createElement("dt"), { textContent: name }), Object.assign(document.createElement("dd"), { textContent: value }));
  }
  info.append(title, list);
}

function focus(room) {
  document.querySelectorAll("#rooms button").forEach((b) => b.setAttribute("aria-current", String(b === room.button)));
  const own = parts.filter((p) => p.extras.room_id === room.id && p.extras.surface);
  if (eye.mode === "walk") enter(room);
  else { eye.elevation = Math.max(eye.elevation, 1.05); fit(own, 0.75); }
  describe(own.find((p) => p.extras.kind === "floor"));
  refresh();
}

function insidePoint(floor) {
  // Centre of the floor's largest triangle: inside the room whatever its shape.
  const p = floor.position, corner = (i) => [p[3 * i], 0, p[3 * i + 2]];
  let best = -1, point = [0, 0];
  for (let k = 0; k < floor.index.length; k += 3) {
    const [a, b, c] = [0, 1, 2].map((j) => corner(floor.index[k + j]));
    const area = Math.hypot(...cross(add(b, a, -1), add(c, a, -1)));
    if (area > best) { best = area; point = [(a[0] + b[0] + c[0]) / 3, (a[2] + b[2] + c[2]) / 3]; }
  }
  return point;
}

function listRooms(entries) {
  const count = {}, seen = {};
  const name = (r) => r.types.join(" / ");
  entries.forEach((r) => { count[name(r)] = (count[name(r)] || 0) + 1; });
  rooms = entries.map((r) => {
    seen[name(r)] = (seen[name(r)] || 0) + 1;
    const floor = parts.find((p) => p.name === `${r.id}/floor`);
    return { ...r, title: count[name(r)] > 1 ? `${name(r)} ${seen[name(r)]}` : name(r), area: areaOf(floor), inside: insidePoint(floor) };
  });
  for (const room of rooms) {
    room.button = document.createElement("button");
    room.button.type = "button";
    const area = Object.assign(document.createElement("span"), { textContent: `${room.area.toFixed(1)} m\u00b2` });
    room.button.append(room.title, area);
    room.button.addEventListener("click", () => focus(room));
    const item = document.createElement("li");
    item.append(room.button);
    $("rooms").append(item);
  }
}

function setMode(mode) {
  if (mode === "walk" && eye.mode !== "walk") {
    enter(rooms.find((r) => r.button.getAttribute("aria-current") === "true") || rooms.reduce((a, b) => (b.area > a.area ? b : a)));
    $("ceilings").checked = show.ceilings = true;
  } else if (mode === "orbit" && eye.mode === "walk") {
    $("ceilings").checked = show.ceilings = false;
  }
  eye.mode = mode;
  $("orbit").setAttribute("aria-pressed", String(mode === "orbit"));
  $("walk").setAttribute("aria-pressed", String(mode === "walk"));
  $("help").textContent = HELP[mode];
  refresh();
}

function listen() {
  const pointers = new Map();
  let travelled = 0;
  canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    if (!pointers.size) travelled = 0;
    pointers.set(e.pointerId, e);
  });
  canvas.addEventListener("pointermove", (e) => {
    const last = pointers.get(e.pointerId);
    if (!last) return;
    const dx = e.clientX - last.clientX, dy = e.clientY - last.clientY;
    travelled += Math.abs(dx) + Math.abs(dy);
    if (pointers.size === 2) {
      const other = [...pointers.entries()].find(([id]) => id !== e.pointerId)[1];
      const gap = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY) || 1;
      zoomBy(gap(last) / gap(e));
      moveBy(dx / 2, dy / 2);
    } else if (eye.mode === "orbit" && (e.buttons & 6 || e.shiftKey)) moveBy(dx, dy);
    else turnBy(dx, dy);
    pointers.set(e.pointerId, e);
    refresh();
  });
  const release = (e) => {
    if (pointers.delete(e.pointerId) && e.type === "pointerup" && travelled < 5) {
      chosen = pick(e.clientX, e.clientY);
      chosenAt = performance.now();
      describe(chosen);
      refresh();
    }
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoomBy(Math.exp(e.deltaY * 0.001)); refresh(); }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    const key = e.key.toLowerCase();
    if (key === "+" || key === "=") zoomBy(0.9);
    else if (key === "-") zoomBy(1.1);
    else if (key === "escape") describe(null);
    else if (/^([wasd]|arrow.*)$/.test(key) && !e.ctrlKey && !e.metaKey) {
      if (!keys.size) lastTime = performance.now();
      keys.add(key);
    } else return;
    e.preventDefault();
    refresh();
  });
  canvas.addEventListener("keyup", (e) => keys.delete(e.key.toLowerCase()));
  canvas.addEventListener("blur", () => keys.clear());
  $("orbit").addEventListener("click", () => setMode("orbit"));
  $("walk").addEventListener("click", () => { setMode("walk"); canvas.focus(); });
  $("plan").addEventListener("click", () => { setMode("orbit"); Object.assign(eye, { azimuth: 0, elevation: 1.5706 }); fit(parts, 0.9); refresh(); });
  for (const name of ["ceilings", "shells"]) $(name).addEventListener("change", (e) => { show[name] = e.target.checked; refresh(); });
  new ResizeObserver(refresh).observe(canvas);
}

async function start() {
  startGl();
  const glb = readGlb(base64Bytes($("house").textContent));
  parts = readParts(glb);
  parts.forEach(uploadPart);
  const { centre, size } = bounds(parts);
  house = { centre, radius: Math.hypot(...size) / 2 };
  const shades = new Set(parts.map((part) => part.shade));
  textures = (await readImages(glb)).map((image, k) => (shades.has(k) ? uploadShade : uploadTexture)(image));
  gl.bindVertexArray(null);
  listRooms(glb.json.scenes[0].extras.rooms);
  listen();
  setMode("orbit");
  fit(parts, 0.92);
  $("message").textContent = "";
  document.body.dataset.ready = "true";
}

start().catch((error) => { $("message").textContent = error.message; console.error(error); });
