"use strict";
// The eye: orbit around a target, or walk; its matrix, and how it moves. State: `eye` in viewer.js.

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

function enter(room) {
  // Stands in a room and looks along its longer side, where there is more of it.
  const { centre, size } = bounds(parts.filter((p) => p.name === `${room.id}/floor`));
  const across = centre[0] >= room.inside[0] ? 1 : -1, along = centre[2] >= room.inside[1] ? 0 : Math.PI;
  eye.position = [room.inside[0], EYE, room.inside[1]];
  eye.yaw = size[0] > size[2] ? (across * Math.PI) / 2 : along;
  eye.pitch = -0.08;
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
