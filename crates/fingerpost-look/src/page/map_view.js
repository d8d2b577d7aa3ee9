// A map from above: roads, a route with its features, and an arrow, which stays in the middle.

import { svgElement } from "./dom.js";

/// Widths of the map, metres: as near as a place can be told, and as far as a town reaches.
const SPANS_M = [60, 120, 250, 500, 1000, 2000, 5000, 10000, 20000];
/// Height of the map for its width.
const ASPECT = 0.7;

/// East and north as places of the drawing, whose second coordinate goes down.
export const drawnAt = ([east, north]) => [east, -north];
export const points = (line) => line.map((place) => drawnAt(place).join(",")).join(" ");

export class MapView {
  /// Draws into an SVG, at first as much as is `wide_m`; `above` lies over the roads, beneath the arrow.
  constructor(svg, { line_m, roads_m, places }, wide_m, above = []) {
    this.svg = svg;
    this.zoom = Math.max(0, SPANS_M.findIndex((span) => span >= wide_m));
    this.arrow = svgElement("path", { class: "start" });
    this.places = places.map(({ at_m, label }) => {
      const [cx, cy] = drawnAt(at_m);
      return svgElement("circle", { class: "feature", cx, cy }, svgElement("title", {}, label));
    });
    const roads = roads_m.map((road) => svgElement("polyline", { class: "map-road", points: points(road) }));
    svg.replaceChildren(...roads, svgElement("polyline", { class: "route", points: points(line_m) }), ...this.places, ...above, this.arrow);
  }

  get width_m() {
    return SPANS_M[this.zoom];
  }

  /// Draws as much as is shown about the middle, with the arrow at a place, east and north, in a direction.
  drawAt(place, ahead) {
    const width = this.width_m;
    const height = width * ASPECT;
    this.svg.setAttribute("viewBox", `${this.centre[0] - width / 2} ${this.centre[1] - height / 2} ${width} ${height}`);
    for (const circle of this.places) circle.setAttribute("r", width / 60);
    const [[x, y], [dx, dy], size] = [drawnAt(place), drawnAt(ahead), width / 30];
    const corner = (forward, left) => `${x + size * (forward * dx + left * dy)},${y + size * (forward * dy - left * dx)}`;
    this.arrow.setAttribute("d", `M${corner(1.2, 0)}L${corner(-0.8, 0.7)}L${corner(-0.4, 0)}L${corner(-0.8, -0.7)}Z`);
  }

  /// Shows more or less of the map.
  zoomBy(steps) {
    this.zoom = Math.max(0, Math.min(SPANS_M.length - 1, this.zoom + steps));
    this.draw();
  }
}
