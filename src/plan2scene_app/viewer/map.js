"use strict";
// The small map: the storey's rooms from above, and the place of the eye. A click moves the eye there.

const MAP = 150; // longer side in CSS pixels
let outline = null; // {level, scale, low, path}

function outlineOfLevel(level) {
  const floors = parts.filter((part) => part.extras.kind === "floor" && part.level === level);
  const box = boxOf(floors.length ? floors : parts), size = box.getSize(new THREE.Vector3());
  const scale = MAP / Math.max(size.x, size.z, 1), path = new Path2D();
  const at = ({ x, z }) => [(x - box.min.x) * scale, (z - box.min.z) * scale];
  for (const { mesh } of floors) for (const { a, b, c } of trianglesOf(mesh)) {
    path.moveTo(...at(a));
    for (const point of [b, c, a]) path.lineTo(...at(point));
  }
  return { level, scale, low: box.min.clone(), path, floors, size: [size.x * scale, size.z * scale] };
}

function drawMap() {
  const map = $("map");
  map.hidden = eye.mode !== "walk";
  if (map.hidden) return;
  const level = levels.findLast((entry) => eye.feet.y > entry.elevation - 0.5)?.id ?? levels[0]?.id ?? null;
  if (outline?.level !== level) {
    outline = outlineOfLevel(level);
    const [width, height] = outline.size.map((side) => Math.ceil(side) + 12);
    Object.assign(map, { width: 2 * width, height: 2 * height });
    Object.assign(map.style, { width: `${width}px`, height: `${height}px` });
  }
  const pen = map.getContext("2d"), { scale, low, path } = outline;
  pen.setTransform(2, 0, 0, 2, 0, 0);
  pen.clearRect(0, 0, map.width, map.height);
  pen.translate(6, 6);
  pen.fillStyle = pen.strokeStyle = "#cfc8bb";
  pen.fill(path);
  pen.stroke(path);
  pen.translate((eye.feet.x - low.x) * scale, (eye.feet.z - low.z) * scale);
  pen.rotate(-eye.yaw);
  pen.fillStyle = "#8a4b2a55";
  pen.beginPath();
  pen.moveTo(0, 0);
  pen.arc(0, 0, 26, Math.PI / 2 - 0.5, Math.PI / 2 + 0.5);
  pen.fill();
  pen.fillStyle = "#8a4b2a";
  pen.beginPath();
  pen.arc(0, 0, 4.5, 0, 2 * Math.PI);
  pen.fill();
}

function clickMap(event) {
  const { scale, low, floors } = outline, at = (value) => (value - 6) / scale;
  const x = low.x + at(event.offsetX), z = low.z + at(event.offsetY);
  const ray = new THREE.Raycaster(new THREE.Vector3(x, floors[0].box.max.y + 1, z), new THREE.Vector3(0, -1, 0));
  const [hit] = ray.intersectObjects(floors.map((part) => part.mesh), false);
  if (hit) goTo(hit.point);
}
