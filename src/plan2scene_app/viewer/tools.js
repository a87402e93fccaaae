"use strict";
// Actions of a click: facts of a surface with its photo crop, photos, the tape measure.

const FLASH = 900; // milliseconds for which a clicked surface glows
const SNAP = 14; // a click within this many CSS pixels of a corner or a photo selects it
const INK = 0x8a4b2a;
let chosen = null, chosenAt = -Infinity;
const tape = { on: false, points: [] };
let tapeLine, tapeEnds, frusta;

const text = (tag, content) => Object.assign(document.createElement(tag), { textContent: content });

function letGo() {
  setTape(false);
  stop();
  describe(null);
}

function show(title, rows, ...more) {
  const close = Object.assign(text("button", "\u00d7"), { type: "button", className: "close" });
  close.setAttribute("aria-label", "Close");
  close.addEventListener("click", letGo);
  $("info").replaceChildren(close, text("h2", title), listOfFacts(rows), ...more);
  $("info").hidden = false;
}

function listOfFacts(rows) {
  const list = document.createElement("dl");
  for (const [name, value] of rows) if (value) list.append(text("dt", name), text("dd", value));
  return list;
}

// Lengths and areas in the chosen unit.
const FOOT = 0.3048;
let feet = false;
const metres = (value) => {
  const inches = Math.round((value / FOOT) * 12);
  return feet ? `${Math.floor(inches / 12)}' ${inches % 12}"` : `${value.toFixed(2)} m`;
};
const area = (value, digits) => (feet ? `${(value / FOOT ** 2).toFixed(0)} sq ft` : `${value.toFixed(digits)} m\u00b2`);
const likely = (value) => (value == null ? "" : value >= 0.75 ? ", likely so" : value >= 0.4 ? ", may be wrong" : ", hardly more than a guess");

function rayAt(x, y, canvas) {
  const box = canvas.getBoundingClientRect();
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2), camera);
  return ray;
}

function pick(x, y, canvas) {
  // The nearest visible surface at a point of the canvas (CSS pixels): {part, point, corners} or null.
  const shown = parts.filter((part) => part.mesh.visible && !part.glass);
  const [hit] = rayAt(x, y, canvas).intersectObjects(shown.map((part) => part.mesh), false);
  if (!hit) return null;
  const { position } = hit.object.geometry.attributes;
  const corners = [hit.face.a, hit.face.b, hit.face.c].map((k) => hit.object.localToWorld(new THREE.Vector3().fromBufferAttribute(position, k)));
  return { part: shown.find((part) => part.mesh === hit.object), point: hit.point, corners };
}

function onScreen(point, canvas) {
  // Position of a world point in the picture, CSS pixels; null behind the eye.
  const seen = point.clone().project(camera);
  return seen.z > 1 ? null : { x: ((seen.x + 1) / 2) * canvas.clientWidth, y: ((1 - seen.y) / 2) * canvas.clientHeight };
}

const near = (place, x, y) => place && Math.hypot(place.x - x, place.y - y) < SNAP;
const capital = (word) => word.replace(/^./, (c) => c.toUpperCase());
const share = (value) => value.toFixed(2).replace(/^0/, "");

// In the studio, a clicked surface is sent to the outer page, which answers with the colour to show.
const doorOf = ({ extras }) => extras.kind === "door" && extras.opening_id;
const surfaceOf = ({ extras }) => (["skirting", "window", "passage"].includes(extras.kind) ? "trim" : extras.surface);

function tellStudio(part, title) {
  if (window.parent === window) return;
  const room = doorOf(part) || part.extras.room_id, surface = doorOf(part) ? "door" : surfaceOf(part);
  window.parent.postMessage({ kind: "surface", room, surface, title, place: placeNow() }, "*");
}

function paintAs({ room, surface, colour }) {
  for (const part of parts) {
    const own = surface === "door" ? doorOf(part) === room : part.extras.room_id === room && (surfaceOf(part) === surface || surfaceOf(part)?.startsWith(`${surface}.`));
    if (!own) continue;
    const levels = [1, 3, 5].map((k) => (parseInt(colour.slice(k, k + 2), 16) / 255) ** 2);
    part.painted = true;
    Object.assign(part.mesh.material, { map: null, needsUpdate: true });
    part.mesh.material.color.setRGB(...levels);
  }
  refresh();
}

window.addEventListener("message", ({ source, data }) => {
  if (source === window.parent && source !== window && data?.kind === "paint" && /^#[0-9a-f]{6}$/i.test(data.colour)) paintAs(data);
});

function describe(part) {
  if (!part) { $("info").hidden = true; return; }
  const { extras } = part;
  const titleOf = (id) => rooms.find((room) => room.id === id)?.title;
  const known = facts.surfaces[`${extras.room_id}/${extras.surface}`] || {};
  const photo = facts.photos.find((entry) => entry.name === known.photo);
  const guess = `guessed: no photo shows it${likely(known.confidence)}`;
  const byHand = extras.evidence?.startsWith("set by hand");
  const seen = photo ? `seen in photo ${photo.number} (${photo.name})` : "seen in photos";
  const words = extras.evidence && photo ? `${extras.evidence}; this piece in photo ${photo.number} (${photo.name})` : extras.evidence;
  const name = extras.kind === "structure" ? "outer wall" : extras.category || extras.kind || part.name;
  tellStudio(part, `${capital(surfaceOf(part) === "trim" ? "skirting and frames" : name)}${titleOf(extras.room_id) ? `, ${titleOf(extras.room_id)}` : ""}`);
  const rows = [["Room", titleOf(extras.room_id)], ["Leads to", titleOf(extras.leads_to)], ["Area", extras.surface ? area(areaOf(part), 2) : null], ["Material", [extras.substance, extras.pattern].filter(Boolean).join(", ") || null],
    ["Looks", byHand ? extras.evidence : words || (extras.observed === undefined ? null : extras.observed ? seen : guess)]];
  const research = document.createElement("details");
  research.append(text("summary", "For researchers"), listOfFacts([["Wall", extras.wall_id], ["Sure", known.confidence == null ? null : share(known.confidence)], ["As", extras.observed === false ? known.source : null],
    ["Texture", extras.source], ["Tile", extras.size_m ? `${extras.size_m.toFixed(2)} m` : null]]));
  const pictures = known.crop && !byHand ? [Object.assign(new Image(), { src: known.crop, alt: "The photo's piece that shows this surface" }), text("small", "As the photo shows it, in its own light")] : [];
  show(capital(name), rows, ...pictures, ...(extras.surface ? [research] : []));
}

function drawFrusta() {
  // The viewing pyramids (frusta) of located photos, half a metre deep.
  const lines = [];
  for (const photo of facts.photos) {
    if (!photo.position) continue;
    const [right, down, ahead] = photo.rotation.map((row) => new THREE.Vector3(...row));
    const centre = new THREE.Vector3(...photo.position);
    photo.point = centre;
    const corner = (x, y) => centre.clone().addScaledVector(ahead, 0.5)
      .addScaledVector(right, (0.5 * (x - photo.width / 2)) / photo.focal_px).addScaledVector(down, (0.5 * (y - photo.height / 2)) / photo.focal_px);
    const ring = [corner(0, 0), corner(photo.width, 0), corner(photo.width, photo.height), corner(0, photo.height)];
    ring.forEach((point, k) => lines.push(centre, point, point, ring[(k + 1) % 4]));
  }
  frusta = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(lines), new THREE.LineBasicMaterial({ color: INK, depthTest: false, toneMapped: false }));
  Object.assign(frusta, { visible: false, renderOrder: 2 });
  $("shots").parentElement.hidden = !lines.length;
  return frusta;
}

function photoAt(x, y, canvas) {
  return frusta.visible && facts.photos.find((photo) => photo.point && near(onScreen(photo.point, canvas), x, y));
}

function describePhoto(photo) {
  const button = (label, go) => {
    const made = Object.assign(text("button", label), { type: "button" });
    made.addEventListener("click", go);
    return made;
  };
  const row = Object.assign(document.createElement("div"), { className: "row" });
  row.append(button("\u2039 Previous", () => nextPhoto(photo, -1)), button("Look from there", () => flyTo(photo)), button("Next \u203a", () => nextPhoto(photo, 1)));
  const room = rooms.find((entry) => entry.id === photo.room_id), known = photo.located >= 0.75 ? "known well" : photo.located >= 0.4 ? "known roughly" : "hardly known";
  show(`Photo ${photo.number}`, [["File", photo.name], ["Taken in", room?.title], ["Its place is", known]], row);
  blending.hidden = !photo.image;
  $("info").append(blending);
}

function makeTape() {
  const shape = { color: INK, depthTest: false, depthWrite: false, toneMapped: false };
  tapeLine = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial(shape));
  tapeEnds = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ ...shape, size: 9, sizeAttenuation: false }));
  for (const shown of [tapeLine, tapeEnds]) { shown.frustumCulled = false; shown.renderOrder = 2; }
  return [tapeLine, tapeEnds];
}

function measure(x, y, canvas) {
  // Adds a point, or the corner near it; the second one gives the distance, the third starts again.
  const hit = pick(x, y, canvas);
  if (!hit) return;
  const corner = hit.corners.find((point) => near(onScreen(point, canvas), x, y));
  tape.points = [...(tape.points.length === 2 ? [] : tape.points), corner || hit.point];
  stretch();
}

function stretch() {
  const { points } = tape;
  tapeLine.geometry.dispose();
  tapeEnds.geometry.dispose();
  tapeLine.geometry = new THREE.BufferGeometry().setFromPoints(points.length === 2 ? points : []);
  tapeEnds.geometry = new THREE.BufferGeometry().setFromPoints(points);
  tapeLine.visible = points.length === 2;
  tapeEnds.visible = points.length > 0;
  if (points.length === 2) {
    const [a, b] = points;
    show(metres(a.distanceTo(b)), [["Level", metres(Math.hypot(a.x - b.x, a.z - b.z))], ["Height", metres(Math.abs(a.y - b.y))]]);
  } else if (tape.on) show("Measure", [], text("p", points.length ? "Click the second point." : "Click two points; near a corner the corner counts."));
}

function setTape(on) {
  Object.assign(tape, { on, points: [] });
  $("measure").setAttribute("aria-pressed", String(on));
  $("info").hidden = true;
  stretch();
  refresh();
}

function label(canvas) {
  // Writes the distance beside the tape's middle.
  const [a, b] = tape.points;
  const place = b && onScreen(a.clone().add(b).multiplyScalar(0.5), canvas);
  $("label").hidden = !place;
  if (!place) return;
  $("label").textContent = metres(a.distanceTo(b));
  Object.assign($("label").style, { left: `${place.x}px`, top: `${place.y}px` });
}
