// The route on its map, seen from above, with the drive's start, which is dragged along it.

import { element } from "./shapes.js";

/// Widths of the map, metres: as near as a start can be told, and as far as a town reaches.
const SPANS_M = [60, 120, 250, 500, 1000, 2000, 5000, 10000, 20000];
/// Height of the map for its width.
const ASPECT = 0.7;
/// Where a route passes a place twice, its place that is so much farther along for every metre is taken for another.
const SAME_PASS = 0.02;

/// East and north as places of the drawing, whose second coordinate goes down.
const drawnAt = ([east, north]) => [east, -north];
const points = (line) => line.map((place) => drawnAt(place).join(",")).join(" ");

export class RouteMap {
  /// Draws into an SVG; `moved` is told where the start is dragged to, metres along the route.
  constructor(svg, map, moved) {
    this.svg = svg;
    this.map = map;
    this.moved = moved;
    this.length_m = map.length_m;
    this.along_m = [0];
    for (const [i, [east, north]] of map.line_m.entries()) {
      if (i) this.along_m.push(this.along_m[i - 1] + Math.hypot(east - map.line_m[i - 1][0], north - map.line_m[i - 1][1]));
    }
    this.zoom = SPANS_M.findIndex((span) => span >= Math.min(250, map.length_m));
    this.start = element("path", { class: "start" });
    this.places = map.places.map(({ at_m, label }) => {
      const [cx, cy] = drawnAt(at_m);
      return element("circle", { class: "feature", cx, cy }, element("title", {}, label));
    });
    const roads = map.roads_m.map((road) => element("polyline", { class: "map-road", points: points(road) }));
    svg.replaceChildren(...roads, element("polyline", { class: "route", points: points(map.line_m) }), ...this.places, this.start);
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
    const width = SPANS_M[this.zoom];
    const height = width * ASPECT;
    this.svg.setAttribute("viewBox", `${this.centre[0] - width / 2} ${this.centre[1] - height / 2} ${width} ${height}`);
    for (const place of this.places) place.setAttribute("r", width / 60);
    const { place, ahead } = this.at(this.start_m);
    const [[x, y], [dx, dy], size] = [drawnAt(place), drawnAt(ahead), width / 30];
    const corner = (forward, left) => `${x + size * (forward * dx + left * dy)},${y + size * (forward * dy - left * dx)}`;
    this.start.setAttribute("d", `M${corner(1.2, 0)}L${corner(-0.8, 0.7)}L${corner(-0.4, 0)}L${corner(-0.8, -0.7)}Z`);
    this.svg.setAttribute("aria-label", `The route on its map, ${width} m across; it begins at ${this.start_m.toFixed(1)} m`);
  }

  /// Shows more or less of the map.
  zoomBy(steps) {
    this.zoom = Math.max(0, Math.min(SPANS_M.length - 1, this.zoom + steps));
    this.draw();
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
    const scale = SPANS_M[this.zoom] / box.width;
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
