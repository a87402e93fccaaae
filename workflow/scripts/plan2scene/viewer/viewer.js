"use strict";
// The viewer: WebGL 2, orbit and walk cameras, rooms by name, what a clicked surface is.

const VERTEX = `#version 300 es
layout(location=0) in vec3 position; layout(location=1) in vec3 normal;
layout(location=2) in vec2 uv; layout(location=3) in vec3 colour;
uniform mat4 camera; out vec3 n; out vec2 t; out vec3 c;
void main() { n = normal; t = uv; c = colour; gl_Position = camera * vec4(position, 1.0); }`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; in vec2 t; in vec3 c; out vec4 pixel;
uniform sampler2D tile; uniform vec4 factor; uniform bool textured; uniform float glow;
vec3 encode(vec3 x) { return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x)); }
void main() {
  vec3 base = factor.rgb * c * (textured ? texture(tile, t).rgb : vec3(1.0));
  vec3 m = normalize(gl_FrontFacing ? n : -n);
  float light = mix(0.62, 0.84, 0.5 + 0.5 * m.y) + 0.26 * max(dot(m, vec3(-0.45, 0.78, 0.43)), 0.0);
  if (m.y < -0.5) light = 0.88;
  vec3 lit = mix(base * light, vec3(0.95, 0.55, 0.25), glow);
  pixel = vec4(encode(clamp(lit, 0.0, 1.0)), factor.a);
}`;
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

// Vectors and matrices (column-major 4x4).
const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const l = Math.hypot(...a) || 1; return [a[0] / l, a[1] / l, a[2] / l]; };

function frame() {
  // Position of the eye and its right, up and forward directions.
  const walk = eye.mode === "walk";
  const yaw = walk ? eye.yaw : eye.azimuth + Math.PI;
  const pitch = walk ? eye.pitch : -eye.elevation;
  const forward = [Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch)];
  const right = [-Math.cos(yaw), 0, Math.sin(yaw)];
  const position = walk ? eye.position : add(eye.target, forward, -eye.distance);
  return { position, right, up: cross(right, forward), forward };
}

const tangent = () => Math.tan(FIELDS[eye.mode] / 2);

function shift() {
  // How far right the middle of the picture lies in clip space: beside the panel, on wide screens.
  const panel = $("panel").getBoundingClientRect();
  return eye.mode === "orbit" && panel.width < 0.4 * canvas.clientWidth ? panel.right / canvas.clientWidth : 0;
}

function matrix() {
  const { position: p, right: r, up: u, forward: f } = frame();
  // As tight as the house allows: rooms' walls stand back to back.
  const away = dot(add(house.centre, p, -1), f);
  const near = Math.max(0.05, away - house.radius), far = Math.max(near + 1, away + house.radius);
  const s = 1 / tangent(), aspect = canvas.width / canvas.height || 1;
  const a = (far + near) / (near - far), b = (2 * far * near) / (near - far);
  const row = (v, k) => [v[0] * k, v[1] * k, v[2] * k, -dot(v, p) * k];
  const w = row(f, 1), x = row(r, s / aspect).map((v, i) => v + shift() * w[i]), y = row(u, s), z = w.map((v, i) => -a * v + (i === 3 ? b : 0));
  return new Float32Array([0, 1, 2, 3].flatMap((i) => [x[i], y[i], z[i], w[i]]));
}

function shader(type, source) {
  const made = gl.createShader(type);
  gl.shaderSource(made, source);
  gl.compileShader(made);
  if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made));
  return made;
}

function startGl() {
  // Edges are smoothed by drawing larger (draw): multisampling lets the wall behind a corner
  // shine through on software renderers.
  gl = canvas.getContext("webgl2", { antialias: false });
  if (!gl) throw new Error("This browser has no WebGL 2. house.glb opens in any glTF program.");
  program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER, VERTEX));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER, FRAGMENT));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  uniforms = Object.fromEntries(["camera", "tile", "factor", "textured", "glow"].map((n) => [n, gl.getUniformLocation(program, n)]));
  gl.enable(gl.DEPTH_TEST);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
}

function uploadPart(part) {
  part.array = gl.createVertexArray();
  gl.bindVertexArray(part.array);
  const fallback = { 1: [0, 1, 0], 2: [0, 0], 3: [1, 1, 1] };
  [[part.position, 3], [part.normal, 3], [part.uv, 2], [part.colour, 3]].forEach(([data, size], place) => {
    if (!data) { gl[`vertexAttrib${size}fv`](place, fallback[place]); return; }
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
  });
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, part.index, gl.STATIC_DRAW);
  part.type = part.index instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
}

function uploadTexture(image) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  const sharp = gl.getExtension("EXT_texture_filter_anisotropic");
  if (sharp) gl.texParameterf(gl.TEXTURE_2D, sharp.TEXTURE_MAX_ANISOTROPY_EXT, Math.min(8, gl.getParameter(sharp.MAX_TEXTURE_MAX_ANISOTROPY_EXT)));
  URL.revokeObjectURL(image.src);
  return made;
}

// Ceilings that are shown also close the house from above.
const twoSided = (part) => part.glass || part.extras.kind === "ceiling";
const shown = (part) => (part.extras.kind !== "ceiling" || show.ceilings) && (part.extras.kind !== "structure" || show.shells);

function draw() {
  const scale = Math.max(2, window.devicePixelRatio || 1);
  const width = Math.round(canvas.clientWidth * scale), height = Math.round(canvas.clientHeight * scale);
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  gl.viewport(0, 0, width, height);
  gl.clearColor(0.969, 0.965, 0.953, 1);
  gl.depthMask(true);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.useProgram(program);
  gl.uniformMatrix4fv(uniforms.camera, false, matrix());
  gl.uniform1i(uniforms.tile, 0);
  const glow = 0.3 * Math.max(0, 1 - (performance.now() - chosenAt) / FLASH);
  for (const glass of [false, true]) {
    gl[glass ? "enable" : "disable"](gl.BLEND);
    gl.depthMask(!glass);
    for (const part of parts) {
      if (part.glass !== glass || !shown(part)) continue;
      gl[twoSided(part) ? "disable" : "enable"](gl.CULL_FACE);
      gl.bindVertexArray(part.array);
      gl.vertexAttrib3f(3, 1, 1, 1);
      gl.uniform4fv(uniforms.factor, part.factor);
      gl.uniform1i(uniforms.textured, part.image === null ? 0 : 1);
      gl.uniform1f(uniforms.glow, part === chosen ? glow : 0);
      if (part.image !== null) gl.bindTexture(gl.TEXTURE_2D, textures[part.image]);
      gl.drawElements(gl.TRIANGLES, part.index.length, part.type, 0);
    }
  }
}

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

function step(seconds) {
  // Walk (or move the orbit's target) with the keys that are down.
  const along = (keys.has("w") || keys.has("arrowup") ? 1 : 0) - (keys.has("s") || keys.has("arrowdown") ? 1 : 0);
  const across = (keys.has("d") ? 1 : 0) - (keys.has("a") ? 1 : 0);
  const turn = (keys.has("arrowright") ? 1 : 0) - (keys.has("arrowleft") ? 1 : 0);
  if (!along && !across && !turn) return keys.size > 0;
  const { right, forward } = frame();
  const ahead = unit([forward[0], 0, forward[2]]);
  const speed = (eye.mode === "walk" ? 1.8 : 0.5 * eye.distance) * seconds;
  const place = eye.mode === "walk" ? "position" : "target";
  eye[place] = add(add(eye[place], ahead, along * speed), right, across * speed);
  eye.yaw -= turn * 1.6 * seconds;
  if (eye.mode === "orbit") eye.azimuth -= turn * 1.2 * seconds;
  return true;
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

function bounds(list) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const part of list) for (let i = 0; i < part.position.length; i++) {
    low[i % 3] = Math.min(low[i % 3], part.position[i]);
    high[i % 3] = Math.max(high[i % 3], part.position[i]);
  }
  return { centre: low.map((v, i) => (v + high[i]) / 2), size: high.map((v, i) => v - low[i]) };
}

function fit(list, share) {
  // Looks at the middle of some parts from where their box fills `share` of the free picture.
  const { centre, size } = bounds(list);
  eye.target = centre;
  eye.distance = 1.5 * Math.hypot(...size);
  const wide = (canvas.clientWidth / canvas.clientHeight || 1) * (1 - shift());
  for (let pass = 0; pass < 6; pass++) {
    const { position, right, up, forward } = frame();
    let spread = 0;
    for (let k = 0; k < 8; k++) {
      const offset = [0, 1, 2].map((i) => centre[i] + ((k >> i) & 1 ? 0.5 : -0.5) * size[i] - position[i]);
      const reach = Math.max(0.1, dot(offset, forward)) * tangent();
      spread = Math.max(spread, Math.abs(dot(offset, right)) / reach / wide, Math.abs(dot(offset, up)) / reach);
    }
    eye.distance *= spread / share;
  }
}

function focus(room) {
  document.querySelectorAll("#rooms button").forEach((b) => b.setAttribute("aria-current", String(b === room.button)));
  const own = parts.filter((p) => p.extras.room_id === room.id && p.extras.surface);
  if (eye.mode === "walk") enter(room);
  else { eye.elevation = Math.max(eye.elevation, 1.05); fit(own, 0.75); }
  describe(own.find((p) => p.extras.kind === "floor"));
  refresh();
}

function enter(room) {
  // Stands in a room and looks along its longer side, where there is more of it.
  const { centre, size } = bounds(parts.filter((p) => p.name === `${room.id}/floor`));
  const across = centre[0] >= room.inside[0] ? 1 : -1, along = centre[2] >= room.inside[1] ? 0 : Math.PI;
  eye.position = [room.inside[0], EYE, room.inside[1]];
  eye.yaw = size[0] > size[2] ? (across * Math.PI) / 2 : along;
  eye.pitch = -0.08;
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

function turnBy(dx, dy) {
  if (eye.mode === "walk") {
    eye.yaw += dx * 0.004;
    eye.pitch = Math.max(-1.4, Math.min(1.4, eye.pitch + dy * 0.004));
  } else {
    eye.azimuth -= dx * 0.006;
    eye.elevation = Math.max(0.02, Math.min(1.5706, eye.elevation + dy * 0.006));
  }
}

function moveBy(dx, dy) {
  const { right, up } = frame();
  const metre = (2 * eye.distance * tangent()) / canvas.clientHeight;
  eye.target = add(add(eye.target, right, -dx * metre), up, dy * metre);
}

const zoomBy = (factor) => { eye.distance = Math.max(0.5, Math.min(120, eye.distance * factor)); };

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
  textures = (await readImages(glb)).map(uploadTexture);
  gl.bindVertexArray(null);
  listRooms(glb.json.scenes[0].extras.rooms);
  listen();
  setMode("orbit");
  fit(parts, 0.92);
  $("message").textContent = "";
  document.body.dataset.ready = "true";
}

start().catch((error) => { $("message").textContent = error.message; console.error(error); });
