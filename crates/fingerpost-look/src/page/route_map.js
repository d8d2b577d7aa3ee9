// The route on its map, seen from above, with the drive's start, which is dragged along it.

import { MapView, drawnAt } from "./map_view.js";

/// Where a route passes a place twice, its place that is so much farther along for every metre is taken for another.
const SAME_PASS = 0.02;

export class RouteMap extends MapView {
  /// Draws into an SVG; `moved` is told where the start is dragged to, metres along the route.
  constructor(svg, map, moved) {
    super(svg, map, Math.min(250, map.length_m));
    this.map = map;
    this.moved = moved;
    this.length_m = map.length_m;
    this.along_m = [0];
    for (const [i, [east, north]] of map.line_m.entries()) {
      if (i) this.along_m.push(this.along_m[i - 1] + Math.hypot(east - map.line_m[i - 1][0], north - map.line_m[i - 1][1]));
    }
    svg.addEventListener("pointerdown", (event) => this.begin(event));
    svg.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => this.end());
  }

  /// Place and direction so far along the route.
  at(along_m) {
    const { line_m } = this.map;
    const beyond = this.along_m.findIndex((along) => along > along_m);
    const i = beyond < 0 ? line_m.length - 1 : Math.max(1, beyond);
    const [from, to] = [line_m[i - 1], line_m[i]];
    const length = this.along_m[i] - this.along_m[i - 1] || 1;
    const share = (along_m - this.along_m[i - 1]) / length;
    const ahead = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    return { place: [0, 1].map((axis) => from[axis] + share * (to[axis] - from[axis])), ahead };
  }

  /// How far along the route its place is that is nearest to another.
  nearest([east, north]) {
    let best = { cost: Infinity, along_m: 0 };
    const { line_m } = this.map;
    for (let i = 1; i < line_m.length; i++) {
      const [from, length] = [line_m[i - 1], this.along_m[i] - this.along_m[i - 1]];
      if (!length) continue;
      const ahead = [0, 1].map((axis) => (line_m[i][axis] - from[axis]) / length);
      const along = Math.max(0, Math.min(length, (east - from[0]) * ahead[0] + (north - from[1]) * ahead[1]));
      const beside = Math.hypot(east - from[0] - along * ahead[0], north - from[1] - along * ahead[1]);
      const along_m = this.along_m[i - 1] + along;
      const cost = beside + SAME_PASS * Math.abs(along_m - this.start_m);
      if (cost < best.cost) best = { cost, along_m };
    }
    return best.along_m;
  }

  show(start_m) {
    this.start_m = start_m;
    if (!this.dragged) this.centre = drawnAt(this.at(start_m).place);
    this.draw();
  }

  draw() {
    const { place, ahead } = this.at(this.start_m);
    this.drawAt(place, ahead);
    this.svg.setAttribute("aria-label", `The route on its map, ${this.width_m} m across; it begins at ${this.start_m.toFixed(1)} m`);
  }

  begin(event) {
    event.preventDefault();
    this.svg.setPointerCapture(event.pointerId);
    this.dragged = true;
    this.drag(event);
  }

  drag(event) {
    if (!this.dragged) return;
    const box = this.svg.getBoundingClientRect();
    const scale = this.width_m / box.width;
    const east = this.centre[0] + (event.clientX - box.left - box.width / 2) * scale;
    const south = this.centre[1] + (event.clientY - box.top - box.height / 2) * scale;
    this.moved(this.nearest([east, -south]));
  }

  /// The map moves behind the start once it is let go, so that what is dragged stays under the pointer.
  end() {
    this.dragged = false;
    this.show(this.start_m);
  }
}
