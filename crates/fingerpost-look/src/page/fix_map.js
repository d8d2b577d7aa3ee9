// Where a run has the vehicle on the map, frame by frame, with the way that it has come and its protection level.

import { MapView, drawnAt, points } from "./map_view.js";
import { svgElement } from "./dom.js";

/// Width of the map at first, metres.
const WIDE_M = 120;

/// The stretches of places that follow each other without a gap.
function stretches(places) {
  const found = [[]];
  for (const place of places) {
    if (place) found[found.length - 1].push(place);
    else if (found[found.length - 1].length) found.push([]);
  }
  return found.filter((stretch) => stretch.length);
}

export class FixMap extends MapView {
  /// Draws into an SVG, and says a frame's fix in words.
  constructor(svg, words, { route, fixes_m }) {
    const track = stretches(fixes_m).map((line) => svgElement("polyline", { class: "track", points: points(line) }));
    const bound = svgElement("circle", { class: "bound" });
    super(svg, route ?? { line_m: [], roads_m: [], places: [] }, WIDE_M, [...track, bound]);
    Object.assign(this, { words, fixes_m, bound });
    this.at = fixes_m.find((place) => place);
    this.heading_rad = 0;
  }

  /// Shows the fix of an index of the run; of a frame without one the last place stays, without its arrow.
  show(index, fix) {
    const place = this.fixes_m[index];
    for (const part of [this.arrow, this.bound]) part.toggleAttribute("hidden", !place);
    this.words.textContent = "No fix in this frame.";
    if (place) {
      this.at = place;
      this.heading_rad = fix.heading_rad;
      this.bound.setAttribute("r", fix.bound_m ?? 0);
      const level = fix.bound_m === null ? "no protection level" : `protection level ${fix.bound_m.toFixed(1)} m (ring)`;
      this.words.textContent = `${fix.status ?? "fix"}: sigma ${fix.sigma_m.toFixed(1)} m, ${level}.`;
    }
    this.draw();
  }

  draw() {
    this.centre = drawnAt(this.at);
    const [cx, cy] = this.centre;
    this.bound.setAttribute("cx", cx);
    this.bound.setAttribute("cy", cy);
    this.drawAt(this.at, [Math.cos(this.heading_rad), Math.sin(this.heading_rad)]);
    this.svg.setAttribute("aria-label", `The vehicle on the map, ${this.width_m} m across. ${this.words.textContent}`);
  }
}
