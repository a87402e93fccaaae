// The tool that draws a straight flight of stairs: its foot, then its head.

import { DrawingTool } from "./drawing_tools.js";
import { dist, roundPoint } from "./geometry.js";
import { flightRing, freeId } from "./storeys.js";
import { draw } from "./view.js";

export class StairsTool extends DrawingTool {
  name = "stairs"; key = "t"; cursor = "crosshair"; title = "Stairs";
  hint = "Click where the stairs begin, then where they end: they climb to the floor above.";
  foot = null;

  down(p, event) {
    const point = this.snapped(p, event, this.foot);
    if (!this.foot) this.foot = point;
    else this.finish(point);
    this.app.refresh();
  }
  move(p, event) { this.snapped(p, event, this.foot); this.app.refresh(); }
  finish(head) {
    const { store, rules } = this.app, least = rules.limits.least_flight;
    if (dist(this.foot, head) < least) { this.app.say(`Stairs are at least ${least} m long`); return; }
    const id = freeId("stairs", store.state.plan.stairs ?? []);
    const flight = { id, from: roundPoint(this.foot), to: roundPoint(head), width: rules.flight_width };
    this.cancel();
    store.changePlan({ stairs: [...(store.plan.stairs ?? []), flight] });
    this.app.select({ kind: "stairs", id });
  }
  keydown() { return false; }
  cancel() { const had = this.foot; this.foot = null; return Boolean(had); }
  draw(view) {
    if (this.foot && this.pointer && dist(this.foot, this.pointer.point) > 0.05) {
      const flight = { from: this.foot, to: this.pointer.point, width: this.app.rules.flight_width };
      draw(view.overlay, "path", { d: view.path(flightRing(flight)), class: "draft" });
      view.measure(flight.from, flight.to, this.app.feet);
    }
    this.drawPointer(view);
  }
}
