// The tools that select and move things (corners, walls, rooms, openings) and set the scale by two points.

import { add, cross, dist, dot, edgesOf, inside, mid, nearestOn, ringsOf, roundPoint, sub, times, unit } from "./geometry.js";
import { gridOf, snap } from "./snapping.js";
import { movedCorner, movedRoom, movedWall } from "./moves.js";
import { fixtureRing, flightRing, movedEnds } from "./storeys.js";
import { draw } from "./view.js";
import { nearestWall, segmentOn } from "./walls.js";

export class SelectTool {
  name = "select"; key = "v"; cursor = "default"; title = "Select";
  hint = "Click to choose; drag corners, walls, rooms, doors and windows. Arrow keys move, Delete removes. Alt: no snapping.";
  drag = null;

  constructor(app) { this.app = app; }

  /** The thing at a point: {kind: "corner" | "opening" | "wall" | "room", ...}; null if there is none. */
  find(p) {
    const { store, view, walls, selection } = this.app, near = 9 / view.scale;
    const rooms = store.plan.rooms;
    const corner = rooms.flatMap((room) => ringsOf(room).flat()).find((c) => dist(c, p) <= near);
    const reach = Math.max(near, store.plan.wall_depth / 2);
    const opening = store.plan.openings.find((o) => nearestOn(o.from, o.to, p).distance <= reach + 0.02);
    if (opening && (!corner || selection?.id === opening.id)) return { kind: "opening", id: opening.id };
    if (corner) return { kind: "corner", point: corner };
    const wall = walls.length ? nearestWall(walls, p) : null;
    if (wall && wall.distance <= reach) return { kind: "wall", edge: [wall.wall.start, wall.wall.end] };
    const fixture = store.plan.fixtures?.find((f) => inside([fixtureRing(f)], p));
    if (fixture) return { kind: "fixtures", id: fixture.id };
    const flight = store.plan.stairs?.find((s) => inside([flightRing(s)], p));
    if (flight) return { kind: "stairs", id: flight.id };
    const room = [...rooms].reverse().find((r) => inside(ringsOf(r), p));
    return room ? { kind: "room", id: room.id } : null;
  }

  down(p) {
    const found = this.find(p);
    this.app.select(found);
    this.app.store.endStep();
    this.drag = found ? { found, start: p, before: this.app.store.plan, moved: false } : { pan: true };
  }
  move(p, event) {
    const { drag, app } = this;
    if (!drag || drag.pan) { if (!drag) app.view.svg.style.cursor = this.cursorAt(p); return; }
    if (!drag.moved && dist(p, drag.start) * app.view.scale < 4) return;
    drag.moved = true;
    const plan = this[drag.found.kind](drag, p, event);
    if (plan) app.store.change({ plan }, "drag");
  }
  up() { this.drag = null; this.app.store.endStep(); }
  cursorAt(p) { return { corner: "move", wall: "pointer", opening: "pointer", stairs: "move", fixtures: "move", room: "pointer" }[this.find(p)?.kind] ?? "grab"; }

  corner({ before, found, start }, p, event) {
    const { rules, view } = this.app;
    const others = before.rooms.map((room) => ({ ...room, polygon: room.polygon.filter((c) => dist(c, found.point) > 0.01) }))
      .filter((room) => room.polygon.length > 1).map((room) => ({ ...room, holes: [] }));
    const goal = snap(add(found.point, sub(p, start)), { rooms: others, scale: view.scale, free: event.altKey }).point;
    this.app.selection = { kind: "corner", point: goal };
    return movedCorner(before, found.point, goal, rules.limits);
  }

  wall({ before, found, start }, p, event) {
    const [a, b] = found.edge, way = unit(sub(b, a)), normal = [-way[1], way[0]];
    let distance = dot(sub(p, start), normal);
    if (!event.altKey) distance = this.snappedShift(before, found.edge, normal, distance);
    const goal = found.edge.map((c) => roundPoint(add(c, times(normal, distance))));
    this.app.selection = { kind: "wall", edge: goal };
    return movedWall(before, found.edge, distance, this.app.rules.limits);
  }
  /** A wall's shift, snapped to the line of another corner, or else to the grid. */
  snappedShift(plan, [a, b], normal, distance) {
    const { scale } = this.app.view, step = gridOf(scale);
    const shifts = plan.rooms.flatMap((room) => room.polygon).map((c) => dot(sub(c, a), normal)).filter((v) => Math.abs(v) > 0.01 || Math.abs(distance) < 0.03);
    const best = shifts.sort((u, v) => Math.abs(u - distance) - Math.abs(v - distance))[0];
    return best !== undefined && Math.abs(best - distance) * scale < 8 ? best : Math.round(distance / step) * step;
  }

  room({ before, found, start }, p, event) {
    const room = before.rooms.find((r) => r.id === found.id), { view, walls } = this.app;
    this.drag.walls ??= walls;
    let shift = sub(p, start);
    if (!event.altKey) {
      const others = before.rooms.filter((r) => r.id !== found.id), step = gridOf(view.scale);
      const best = [0, 1].map((axis) => {
        const targets = others.flatMap((r) => r.polygon.map((c) => c[axis]));
        const gaps = room.polygon.flatMap((c) => targets.map((t) => t - c[axis])).sort((u, v) => Math.abs(u - shift[axis]) - Math.abs(v - shift[axis]));
        return gaps.length && Math.abs(gaps[0] - shift[axis]) * view.scale < 9 ? gaps[0] : Math.round(shift[axis] / step) * step;
      });
      shift = best;
    }
    return movedRoom(before, found.id, shift, this.drag.walls);
  }

  stairs(drag, p, event) { return this.moveEnds(drag, p, event); }
  fixtures(drag, p, event) { return this.moveEnds(drag, p, event); }
  moveEnds({ before, found, start }, p, event) {
    const step = gridOf(this.app.view.scale), by = sub(p, start).map((v) => (event.altKey ? v : Math.round(v / step) * step));
    return { ...before, [found.kind]: before[found.kind].map((one) => (one.id === found.id ? movedEnds(one, by) : one)) };
  }

  opening({ before, found, start }, p, event) {
    const opening = before.openings.find((o) => o.id === found.id);
    const goal = add(mid(opening.from, opening.to), sub(p, start));
    const near = nearestWall(this.app.walls, goal);
    if (!near || near.distance > 0.6) return null;
    const along = event.altKey ? near.along : Math.round(near.along / 0.05) * 0.05;
    const [from, to] = segmentOn(near.wall, along, dist(opening.from, opening.to)).map(roundPoint);
    return { ...before, openings: before.openings.map((o) => (o.id === found.id ? { ...o, from, to } : o)) };
  }

  keydown(event) {
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const way = ways[event.key], { selection, store, view } = this.app;
    if (way && selection) {
      const start = selection.kind === "corner" ? selection.point : selection.kind === "wall" ? mid(...selection.edge) : [0, 0];
      const drag = { found: selection, start, before: store.plan };
      this.drag = { ...drag };
      const by = times(way, event.shiftKey ? 0.5 : Math.min(0.1, gridOf(view.scale)));
      const plan = this[selection.kind](drag, add(start, by), { altKey: true });
      this.drag = null;
      if (plan) store.change({ plan }, `arrow ${selection.kind}`);
      return true;
    }
    if ((event.key === "Delete" || event.key === "Backspace") && selection) { this.app.remove(selection); return true; }
    return false;
  }
  cancel() { const had = this.app.selection; this.drag = null; this.app.select(null); return Boolean(had); }

  draw(view) {
    const { selection, store, feet } = this.app;
    if (selection?.kind === "room") {
      const room = store.plan.rooms.find((r) => r.id === selection.id);
      for (const ring of room ? ringsOf(room) : []) for (const [a, b] of edgesOf(ring)) view.measure(a, b, feet);
      for (const c of room ? ringsOf(room).flat() : []) this.handle(view, c);
    } else if (selection?.kind === "wall") {
      view.measure(...selection.edge, feet);
      selection.edge.forEach((c) => this.handle(view, c));
    } else if (selection?.kind === "opening") {
      const opening = store.plan.openings.find((o) => o.id === selection.id);
      if (opening) view.measure(opening.from, opening.to, feet);
    } else if (selection?.kind === "stairs") {
      const flight = store.plan.stairs?.find((s) => s.id === selection.id);
      if (flight) view.measure(flight.from, flight.to, feet);
    } else if (selection?.kind === "corner") {
      this.handle(view, selection.point);
      for (const room of store.plan.rooms) for (const edge of ringsOf(room).flatMap(edgesOf))
        if (edge.some((c) => dist(c, selection.point) < 0.01)) view.measure(...edge, feet);
    }
  }
  handle(view, c) { const [cx, cy] = view.toPixels(c); draw(view.overlay, "circle", { cx, cy, r: 4.5, class: "corner" }); }
}

export class ScaleTool {
  name = "scale"; key = "s"; cursor = "crosshair"; title = "Scale";
  hint = "Click two points whose distance you know: the ends of a dimension line, or of a wall.";
  points = []; pointer = null;

  constructor(app) { this.app = app; }
  at(p, event) { return event.altKey ? p : this.straight(p); }
  /** The pointer, snapped to the horizontal or vertical line through the first point if it is near one. */
  straight(p) {
    const from = this.points[0];
    if (!from) return p;
    const offset = sub(p, from), length = Math.hypot(...offset);
    for (const way of [[1, 0], [0, 1]]) if (Math.abs(cross(offset, way)) < length * 0.04) return add(from, times(way, dot(offset, way)));
    return p;
  }
  down(p, event) {
    if (this.points.length === 1 && dist(this.points[0], p) * this.app.view.scale < 4) return;
    this.points = this.points.length > 1 ? [p] : [...this.points, this.at(p, event)];
    this.app.refresh();
  }
  up() { if (this.points.length === 2) this.app.askScale(...this.points); } // on release, because a press would take the focus from the dialog
  move(p, event) { this.pointer = this.at(p, event); this.app.refresh(); }
  keydown() { return false; }
  cancel() { const had = this.points.length; this.points = []; return Boolean(had); }
  draw(view) {
    const ends = this.points.length === 1 && this.pointer ? [...this.points, this.pointer] : this.points;
    if (ends.length === 2) draw(view.overlay, "path", { d: view.path(ends, false), class: "ruler" });
    for (const p of ends) { const [cx, cy] = view.toPixels(p); draw(view.overlay, "circle", { cx, cy, r: 5, class: "snap angle" }); }
  }
}
