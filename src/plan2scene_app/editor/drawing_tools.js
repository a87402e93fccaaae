// Tools that draw: a room as a rectangle, walls corner by corner, doors and windows on walls.

import { crossing, dist, roundPoint, signedArea } from "./geometry.js";
import { drawnRooms } from "./faces.js";
import { usualHeight, withRoom } from "./document.js";
import { snap } from "./snapping.js";
import { freeId } from "./storeys.js";
import { readLength, readSize } from "./units.js";
import { draw } from "./view.js";
import { nearestWall, segmentOn } from "./walls.js";

/** Whether a line of walls runs through an opening or ends in it. */
function isCut({ from, to }, line) {
  const length = dist(from, to), slack = 0.02;
  return line.slice(1).some((p, k) => {
    const at = crossing(line[k], p, from, to), reach = slack / (dist(line[k], p) || 1);
    return at && at[0] > -reach && at[0] < 1 + reach && at[1] * length > slack && at[1] * length < length - slack;
  });
}

const rectangle = (a, b) => [a, [b[0], a[1]], b, [a[0], b[1]]].map(roundPoint);

/** Base of all tools that draw: a snapped pointer, and text typed while drawing. */
export class DrawingTool {
  pointer = null; typed = "";

  constructor(app) { this.app = app; }
  get rooms() { return this.app.store.plan.rooms; }
  snapped(p, event, from, points = []) {
    const { view } = this.app;
    this.pointer = snap(p, { rooms: this.rooms, scale: view.scale, from, points, free: event.altKey });
    return this.pointer.point;
  }
  /** Collect typed text; returns whether the key was used. */
  type(event) {
    if (event.key === "Backspace" && this.typed) this.typed = this.typed.slice(0, -1);
    else if (/^[\d.,x*'" ]$|^[mcft]$/i.test(event.key) && (this.typed || /^[\d.,]$/.test(event.key))) this.typed += event.key;
    else return false;
    this.app.refresh();
    return true;
  }
  drawPointer(view) {
    for (const [a, b] of this.pointer?.guides ?? []) draw(view.overlay, "path", { d: view.path([a, b], false), class: "guide" });
    if (!this.pointer) return;
    const [x, y] = view.toPixels(this.pointer.point);
    draw(view.overlay, "circle", { cx: x, cy: y, r: this.pointer.kind === "corner" ? 6 : 4, class: `snap ${this.pointer.kind}` });
    if (this.typed) draw(view.overlay, "text", { x: x + 14, y: y - 12, class: "typed" }, this.typed);
  }
  addRoom(polygon) {
    const { store, rules } = this.app;
    const { plan, id } = withRoom(store.plan, polygon, store.state.plan.rooms, usualHeight(store, rules));
    store.change({ plan });
    this.app.select({ kind: "room", id });
    this.app.say(`Room ${id} added`);
  }
}

export class RoomTool extends DrawingTool {
  name = "room"; key = "r"; cursor = "crosshair"; title = "Room";
  hint = "Drag a rectangle, or click two corners. Type a size such as 4.2 x 3 and press Enter.";
  anchor = null;

  down(p, event) {
    const point = this.snapped(p, event, null);
    if (this.anchor) this.finish(point);
    else { this.anchor = point; this.pressed = point; }
  }
  move(p, event) { this.snapped(p, event, null); this.app.refresh(); }
  up(p, event) {
    const point = this.snapped(p, event, null);
    if (this.anchor && this.pressed && dist(point, this.pressed) * this.app.view.scale > 12) this.finish(point);
    this.pressed = null;
  }
  finish(point) {
    const [w, h] = [0, 1].map((k) => Math.abs(point[k] - this.anchor[k]));
    if (w < 0.1 || h < 0.1) return;
    const ring = rectangle(this.anchor, point);
    this.cancel();
    this.addRoom(ring);
  }
  keydown(event) {
    if (event.key === "Enter" && this.typed) {
      const size = readSize(this.typed, this.app.feet);
      if (!size) { this.app.say(`A size such as 4.2 x 3, not ${this.typed}`); return true; }
      const start = this.anchor ?? this.freePlace();
      const way = this.anchor && this.pointer ? [0, 1].map((k) => (this.pointer.point[k] < this.anchor[k] ? -1 : 1)) : [1, 1];
      this.cancel();
      this.addRoom(rectangle(start, [start[0] + way[0] * size[0], start[1] + way[1] * size[1]]));
      return true;
    }
    return this.type(event);
  }
  /** A place to the right of all rooms, at the height of the topmost one. */
  freePlace() {
    const corners = this.rooms.flatMap((room) => room.polygon);
    return corners.length ? [Math.max(...corners.map((c) => c[0])), Math.min(...corners.map((c) => c[1]))] : [0, 0];
  }
  cancel() { const had = this.anchor || this.typed; this.anchor = this.pressed = null; this.typed = ""; return Boolean(had); }
  draw(view) {
    if (this.anchor && this.pointer) {
      const ring = rectangle(this.anchor, this.pointer.point);
      draw(view.overlay, "path", { d: view.path(ring), class: "draft" });
      view.measure(ring[0], ring[1], this.app.feet);
      view.measure(ring[1], ring[2], this.app.feet);
    }
    this.drawPointer(view);
  }
}

export class WallTool extends DrawingTool {
  name = "wall"; key = "w"; cursor = "crosshair"; title = "Walls";
  hint = "Click corner by corner; a closed line is a room, a line across a room divides it. Type a length for the next wall. Enter ends, Backspace takes a corner back.";
  line = [];

  down(p, event) { this.add(this.snapped(p, event, this.line.at(-1) ?? null, this.line)); }
  move(p, event) { this.snapped(p, event, this.line.at(-1) ?? null, this.line); this.app.refresh(); }
  double() { this.finish(); }
  add(point) {
    if (this.line.length && dist(point, this.line.at(-1)) < 0.02) return;
    this.line.push(point);
    this.typed = "";
    const closed = this.line.length > 3 && dist(point, this.line[0]) < 0.01;
    const touches = this.line.length > 1 && this.app.walls.length && nearestWall(this.app.walls, point).distance < 0.01;
    if (closed || (touches && nearestWall(this.app.walls, this.line[0]).distance < 0.01)) this.finish(closed);
    this.app.refresh();
  }
  finish() {
    const { store, rules } = this.app, line = this.line;
    if (line.length < 2) { this.cancel(); return; }
    const hit = store.plan.openings.find((opening) => isCut(opening, line));
    if (hit) {
      line.pop();
      this.app.say(`This wall would cut ${hit.id}: end it beside the ${hit.kind}, or move that first`);
      return;
    }
    const { made, split } = drawnRooms(store.plan.rooms, line, rules.limits.shared_tolerance);
    if (!made.length && !split.size) {
      this.app.say("This line closes no room yet: go on, or press Escape");
      return;
    }
    this.cancel();
    let plan = store.plan, id = "";
    for (const [room, [first, ...others]] of split) {
      plan = { ...plan, rooms: plan.rooms.map((r) => (r.id === room.id ? { ...r, polygon: first } : r)) };
      for (const polygon of others) ({ plan, id } = withRoom(plan, polygon, store.state.plan.rooms, room.height));
    }
    for (const polygon of made) ({ plan, id } = withRoom(plan, signedArea(polygon) > 0 ? polygon : [...polygon].reverse(), store.state.plan.rooms, usualHeight(store, rules)));
    store.change({ plan });
    this.app.select({ kind: "room", id });
    this.app.say(`Room ${id} added`);
  }
  keydown(event) {
    const last = this.line.at(-1);
    if (event.key === "Enter") {
      const length = readLength(this.typed, this.app.feet);
      if (this.typed && length > 0 && last && this.pointer && dist(last, this.pointer.point) > 0) {
        const share = length / dist(last, this.pointer.point);
        this.add(roundPoint([0, 1].map((k) => last[k] + (this.pointer.point[k] - last[k]) * share)));
      } else if (this.typed) this.app.say(`A length such as 3.2, not ${this.typed}`);
      else if (this.line.length > 2 && dist(last, this.line[0]) > 0.01) { this.line.push(this.line[0]); this.finish(); } else this.finish();
      this.app.refresh();
      return true;
    }
    if (event.key === "Backspace" && !this.typed && this.line.length) { this.line.pop(); this.app.refresh(); return true; }
    return this.type(event);
  }
  cancel() { const had = this.line.length || this.typed; this.line = []; this.typed = ""; return Boolean(had); }
  draw(view) {
    const points = this.pointer ? [...this.line, this.pointer.point] : this.line;
    if (this.line.length) {
      draw(view.overlay, "path", { d: view.path(points, false), class: "draft line" });
      for (const p of this.line) { const [cx, cy] = view.toPixels(p); draw(view.overlay, "circle", { cx, cy, r: 4, class: "corner" }); }
      if (this.pointer) view.measure(this.line.at(-1), this.pointer.point, this.app.feet);
    }
    this.drawPointer(view);
  }
}

export class OpeningTool extends DrawingTool {
  cursor = "crosshair"; place = null;

  constructor(app, name, key, title) {
    super(app);
    Object.assign(this, { name, key, title, hint: `Click a wall to put a ${name} in it.` });
  }
  get usual() { return this.app.rules.openings[this.name]; }
  find(p, event) {
    const near = this.app.walls.length ? nearestWall(this.app.walls, p) : null;
    if (!near || near.distance > Math.max(0.3, 18 / this.app.view.scale)) { this.place = null; return; }
    const along = event.altKey ? near.along : Math.round(near.along / 0.05) * 0.05;
    this.place = { wall: near.wall, ends: segmentOn(near.wall, along, this.usual.width).map(roundPoint) };
  }
  move(p, event) { this.find(p, event); this.app.refresh(); }
  down(p, event) {
    this.find(p, event);
    if (!this.place) { this.app.say(`No wall here: a ${this.name} goes into a wall`); return; }
    const { store } = this.app, [from, to] = this.place.ends;
    const id = freeId(this.name, store.state.plan.openings);
    const top = Math.min(this.usual.top, this.place.wall.height);
    store.changePlan({ openings: [...store.plan.openings, { id, kind: this.name, from, to, bottom: this.usual.bottom, top }] });
    this.app.select({ kind: "opening", id });
  }
  keydown() { return false; }
  cancel() { this.place = null; return false; }
  draw(view) {
    if (!this.place) return;
    const width = Math.max(5, this.app.store.plan.wall_depth * view.scale + 3);
    draw(view.overlay, "path", { d: view.path(this.place.ends, false), class: "ghost", "stroke-width": width });
    view.measure(...this.place.ends, this.app.feet);
  }
}
