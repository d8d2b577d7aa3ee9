// Curves over the run, with its events and the moment that is shown.

import { element, svgElement } from "./dom.js";

/// Width and height that a curve is drawn in before it is stretched to its place.
const WIDTH = 1000;
const HEIGHT = 50;

/// The stretches of a curve that have values, thinned to its lowest and highest value a column where a run is long.
function path(values, x, y) {
  const columns = new Map();
  const pieces = [];
  let open = false;
  values.forEach((value, index) => {
    if (value === null) {
      open = false;
      return;
    }
    const column = Math.floor(x(index));
    const at = columns.get(column);
    if (open && at && value >= at.low && value <= at.high) return;
    columns.set(column, { low: Math.min(value, at?.low ?? value), high: Math.max(value, at?.high ?? value) });
    pieces.push(`${open ? "L" : "M"}${x(index).toFixed(2)} ${y(value).toFixed(2)}`);
    // A value alone is a point, which only a line of no length shows.
    if (!open) pieces.push("h0.01");
    open = true;
  });
  return pieces.join("");
}

const shown = (value) => (value === null || value === undefined ? "–" : value.toFixed(Math.abs(value) < 10 ? 2 : 1));

export class Curves {
  /// `go` is called with the time that was clicked on, seconds.
  constructor(box, { times_s, curves, events }, go) {
    const last_s = times_s[times_s.length - 1] || 1;
    const x = (index) => (WIDTH * times_s[index]) / last_s;
    this.x = x;
    const isKnown = ({ values }) => values.some((value) => value !== null);
    this.rows = curves.filter(isKnown).map(({ name, unit, values }) => {
      const known = values.filter((value) => value !== null);
      const least = known.reduce((a, b) => Math.min(a, b), 0);
      const most = unit ? known.reduce((a, b) => Math.max(a, b), least + 1e-3) : 1;
      const y = (value) => HEIGHT - 1 - ((HEIGHT - 2) * (value - least)) / (most - least);
      const marks = Object.entries(Object.groupBy(events, ({ kind }) => kind)).map(([kind, of]) =>
        svgElement("path", { class: `mark ${kind}`, d: of.map(({ index }) => `M${x(index).toFixed(2)} 0V${HEIGHT}`).join("") }),
      );
      // Beside the drawing, which then is not drawn anew with every step.
      const now = element("i", { className: "now" });
      const label = `${name} over the run, ${shown(least)} to ${shown(most)} ${unit}`;
      const svg = svgElement("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", role: "img", "aria-label": label });
      svg.append(...marks, svgElement("path", { d: path(values, x, y) }));
      const number = element("b");
      const words = element("div", { className: "words" }, name, number, `${shown(least)} to ${shown(most)} ${unit}`);
      box.append(element("div", { className: "curve" }, words, element("div", { className: "plot" }, svg, now)));
      return { values, unit, now, number, svg };
    });
    const unknown = curves.filter((curve) => !isKnown(curve)).map(({ name }) => name);
    if (unknown.length) box.append(`Not known in this run: ${unknown.join(", ")}.`);
    box.addEventListener("pointerdown", (event) => {
      if (!this.rows.length) return;
      const place = this.rows[0].svg.getBoundingClientRect();
      const share = (event.clientX - place.left) / place.width;
      if (share >= 0) go(Math.min(1, share) * last_s);
    });
  }

  show(index) {
    for (const { values, unit, now, number } of this.rows) {
      now.style.left = `${(100 * this.x(index)) / WIDTH}%`;
      number.textContent = `${shown(values[index])} ${values[index] === null ? "" : unit}`;
    }
  }
}
