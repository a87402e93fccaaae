// The drawing: an SVG of the state, always redrawn as a whole. Zoom and offset map metres to pixels.

import { labelOf } from "./document.js";
import { add, boundsOf, cross, dist, dot, labelPoint, mid, polygonArea, ringsOf, sub, times, unit } from "./geometry.js";
import { gridOf } from "./snapping.js";
import { fixtureRing, flightRing, riseOf, stepCount } from "./storeys.js";
import { areaText, lengthText } from "./units.js";

const SVG = "http://www.w3.org/2000/svg";

/** A new SVG element with attributes, inside a parent. */
export function draw(parent, name, attributes = {}, text = null) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== null) element.textContent = text;
  parent.append(element);
  return element;
}

export class View {
  scale = 60; // pixels per metre
  offset = [80, 80]; // place of the point 0, 0 in pixels

  constructor(svg) { this.svg = svg; }
  get size() { return [this.svg.clientWidth || 800, this.svg.clientHeight || 600]; }
  toPixels(p) { return add(times(p, this.scale), this.offset); }
  toMetres(p) { return times(sub(p, this.offset), 1 / this.scale); }
  at(event) {
    const box = this.svg.getBoundingClientRect();
    return this.toMetres([event.clientX - box.left, event.clientY - box.top]);
  }
  zoom(factor, pixel = times(this.size, 0.5)) {
    const before = this.toMetres(pixel);
    this.scale = Math.max(4, Math.min(600, this.scale * factor));
    this.offset = sub(pixel, times(before, this.scale));
  }
  fit(points) {
    const { low, high } = points.length ? boundsOf(points) : { low: [-0.5, -0.5], high: [9.5, 6.5] };
    const extent = sub(high, low);
    const [across, up] = this.size.map((side) => Math.max(0.75 * side, side - 120));
    this.scale = Math.max(4, Math.min(160, across / (extent[0] || 1), up / (extent[1] || 1)));
    this.offset = sub(times(this.size, 0.5), times(mid(low, high), this.scale));
  }
  path(points, closed = true) {
    return points.map((p, k) => (k ? "L" : "M") + this.toPixels(p).map((v) => v.toFixed(1)).join(" ")).join("") + (closed ? "Z" : "");
  }

  /** Draw everything; `scene` is {state, walls, problems, selection, picture, feet, photos}. */
  render(scene) {
    this.svg.replaceChildren();
    this.drawGrid();
    if (scene.picture) this.drawPicture(scene);
    const rooms = draw(this.svg, "g", { class: "rooms" });
    const wrong = new Map(scene.problems.filter((p) => p.room).map((p) => [p.room, p.level]));
    for (const room of scene.state.plan.rooms) this.drawRoom(rooms, room, scene, wrong.get(room.id));
    if (scene.below) this.drawBelow(scene.below);
    for (const flight of scene.state.plan.stairs ?? []) this.drawStairs(flight, scene);
    for (const fixture of scene.state.plan.fixtures ?? []) this.drawFixture(fixture, scene);
    this.drawWalls(scene);
    const labels = draw(this.svg, "g", { class: "labels" });
    for (const room of scene.state.plan.rooms) this.drawLabel(labels, room, scene);
    this.overlay = draw(this.svg, "g", { class: "overlay" });
  }

  drawGrid() {
    const step = gridOf(this.scale) * (this.scale > 40 ? 10 : 5), [width, height] = this.size;
    const fine = step * this.scale > 60 ? step / 5 : step;
    const low = this.toMetres([0, 0]), high = this.toMetres([width, height]);
    const grid = draw(this.svg, "g", { class: "grid" });
    for (const axis of [0, 1]) {
      let lines = "", strong = "";
      for (let k = Math.ceil(low[axis] / fine); k * fine < high[axis]; k++) {
        const v = (k * fine * this.scale + this.offset[axis]).toFixed(1);
        const line = axis ? `M0 ${v}H${width}` : `M${v} 0V${height}`;
        if (Math.abs((k * fine) / step - Math.round((k * fine) / step)) < 1e-6) strong += line;
        else lines += line;
      }
      draw(grid, "path", { d: lines });
      draw(grid, "path", { d: strong, class: "strong" });
    }
  }

  drawPicture({ state: { picture: place }, picture }) {
    const [x, y] = this.toPixels([place.x, place.z]), size = place.metres_per_pixel * this.scale;
    const image = draw(this.svg, "image", { href: picture.url, x, y, width: picture.width * size, height: picture.height * size, opacity: place.opacity, preserveAspectRatio: "none", class: "picture" });
    image.style.display = place.visible ? "" : "none";
  }

  /** Draw the floor below: outlines, and the holes for the stairs that come up from it. */
  drawBelow(plan) {
    const group = draw(this.svg, "g", { class: "below" });
    for (const room of plan.rooms) draw(group, "path", { d: ringsOf(room).map((ring) => this.path(ring)).join("") });
    for (const flight of plan.stairs ?? []) draw(group, "path", { d: this.path(flightRing(flight)), class: "well" });
  }
  drawStairs(flight, { selection, levels, limits }) {
    const chosen = selection?.kind === "stairs" && selection.id === flight.id, steps = stepCount(riseOf(flight, levels, limits), limits);
    const group = draw(this.svg, "g", { class: `flight${chosen ? " chosen" : ""}`, "data-stairs": flight.id });
    const [a, b, c, d] = flightRing(flight), at = (p, q, share) => add(p, times(sub(q, p), share));
    draw(group, "path", { d: this.path([a, b, c, d]), class: "strip" });
    const lines = Array.from({ length: steps - 1 }, (_, k) => this.path([at(a, b, (k + 1) / steps), at(d, c, (k + 1) / steps)], false));
    const tip = (side) => at(flight.from, flight.to, 1 - 0.25 * flight.width / (dist(flight.from, flight.to) || 1)).map((v, k) => v + 0.25 * (side[k] - flight.to[k]));
    draw(group, "path", { d: lines.join("") + this.path([flight.from, flight.to], false) + this.path([tip(b), flight.to, tip(c)], false), class: "line" });
  }

  drawFixture(fixture, { selection }) {
    const chosen = selection?.kind === "fixtures" && selection.id === fixture.id;
    const path = draw(this.svg, "path", { d: this.path(fixtureRing(fixture)), class: `fixture${chosen ? " chosen" : ""}`, "data-fixture": fixture.id });
    draw(path, "title", {}, fixture.type);
  }

  drawRoom(parent, room, { selection }, level) {
    const chosen = selection?.kind === "room" && selection.id === room.id;
    const path = draw(parent, "path", {
      d: ringsOf(room).map((ring) => this.path(ring)).join(""), "fill-rule": "evenodd", "data-room": room.id,
      class: `room type-${room.types[0]?.toLowerCase()}${chosen ? " chosen" : ""}${level ? ` ${level}` : ""}`,
    });
    draw(path, "title", {}, labelOf(room));
  }

  drawWalls({ walls, state, selection }) {
    const width = Math.max(2, state.plan.wall_depth * this.scale);
    const group = draw(this.svg, "g", { class: "walls", "stroke-width": width });
    for (const wall of walls) draw(group, "path", { d: this.path([wall.start, wall.end], false) });
    if (selection?.kind === "wall") draw(this.svg, "path", { d: this.path(selection.edge, false), class: "chosen-wall", "stroke-width": width + 4 });
    const holes = draw(this.svg, "g", { class: "openings" });
    const leaves = new Set(); // a door in the walls of two rooms is drawn with one leaf only
    for (const wall of walls) for (const hole of wall.openings) {
      this.drawOpening(holes, wall, hole, width, selection, !leaves.has(hole.opening.id));
      leaves.add(hole.opening.id);
    }
  }

  drawOpening(parent, wall, { opening, start, end }, width, selection, leaf) {
    const along = unit(sub(wall.end, wall.start)), at = (v) => add(wall.start, times(along, v));
    // A leaf swings to the side given by the opening's drawn direction, not by the wall's room.
    const turned = dot(sub(opening.to, opening.from), along) < 0, way = times(along, turned ? -1 : 1);
    const a = at(turned ? end : start), b = at(turned ? start : end), chosen = selection?.kind === "opening" && selection.id === opening.id;
    const group = draw(parent, "g", { class: `opening ${opening.kind}${chosen ? " chosen" : ""}`, "data-opening": opening.id ?? "" });
    draw(group, "title", {}, opening.id ?? "");
    draw(group, "path", { d: this.path([a, b], false), class: "gap", "stroke-width": width + 1 });
    const side = [-way[1], way[0]], half = width / 2 / this.scale;
    if (opening.kind === "window") {
      for (const k of [-1, 0, 1]) draw(group, "path", { d: this.path([a, b].map((p) => add(p, times(side, k * half))), false), class: "line" });
    } else if (opening.kind === "door" && leaf) {
      const [p, q] = [this.toPixels(a), this.toPixels(b)], reach = dist(p, q);
      const tip = this.toPixels(add(a, times(side, dist(a, b))));
      const sweep = cross(sub(q, p), sub(tip, p)) > 0 ? 1 : 0;
      draw(group, "path", { d: `M${q.join(" ")}A${reach} ${reach} 0 0 ${sweep} ${tip.join(" ")}L${p.join(" ")}`, class: "line" });
    } else if (opening.kind !== "door") for (const k of [-1, 1]) draw(group, "path", { d: this.path([a, b].map((p) => add(p, times(side, k * half))), false), class: "line dashed" });
    draw(group, "path", { d: this.path([a, b], false), class: "grip", "stroke-width": Math.max(14, width) });
  }

  drawLabel(parent, room, { feet, state }) {
    const [x, y] = this.toPixels(labelPoint(ringsOf(room)));
    const { low, high } = boundsOf(room.polygon), fits = (high[0] - low[0]) * this.scale;
    if (fits < 34) return;
    const label = labelOf(room);
    const long = 7 * label.length > fits - 8 && fits > 40 ? `${label.slice(0, Math.max(2, Math.floor(fits / 7) - 2))}\u2026` : label;
    draw(parent, "text", { x, y: y - 3, class: "name" }, long);
    draw(parent, "text", { x, y: y + 13, class: "area" }, areaText(polygonArea(ringsOf(room)), feet));
    const photos = state.photos.filter((photo) => photo.rooms.includes(room.id)).length;
    if (photos) draw(parent, "text", { x, y: y + 29, class: "count" }, photos === 1 ? "1 photo" : `${photos} photos`);
  }

  /** Draw the length of a segment beside it. */
  measure(a, b, feet, className = "measure") {
    const [p, q] = [this.toPixels(a), this.toPixels(b)], length = dist(p, q);
    if (length < 24) return;
    const way = unit(sub(q, p)), [x, y] = add(mid(p, q), times([way[1], -way[0]], 13));
    const text = lengthText(dist(a, b), feet), width = text.length * 6.6 + 8;
    draw(this.overlay, "rect", { x: x - width / 2, y: y - 9, width, height: 18, rx: 5, class: `${className}-plate` });
    draw(this.overlay, "text", { x, y: y + 4, class: className }, text);
  }
}
