// Shapes of a frame over the camera's picture and on the road from above. What they are and where, the program says.

import { element, svgElement } from "./dom.js";

/// What is drawn, in the order of the legend, in people's words.
export const KINDS = {
  driving_line: "driving line",
  centreline: "road's middle",
  lane_edge: "lane edges",
  feature: "feature",
  doubt: "two sigma",
  rival: "rivals",
  sought: "searched for",
  horizon: "horizon",
};
/// What of the road lies behind the rear axle and is shown, metres.
const BEHIND_M = 3;

/// One shape's pieces: a place as a ring, a line as it is, each on a dark rim where it lies on a picture.
function drawn({ kind, label }, pieces, ring, rims) {
  return pieces.flatMap((piece) =>
    rims.map((rim) => {
      const made =
        piece.length === 1
          ? svgElement("circle", { cx: piece[0][0], cy: piece[0][1], r: ring })
          : svgElement("polyline", { points: piece.map((place) => place.join(",")).join(" ") });
      made.setAttribute("class", rim ? "rim" : kind);
      made.dataset.kind = kind;
      made.append(svgElement("title", {}, label));
      return made;
    }),
  );
}

function say(svg, what, shapes) {
  svg.setAttribute("aria-label", `${what}: ${[...new Set(shapes.map(({ label }) => label))].join("; ") || "nothing"}`);
}

/// Draws over a picture of such a size; its top-left pixel's middle is (0, 0).
export function drawOverlay(svg, shapes, [width, height]) {
  svg.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
  const seen = shapes.filter(({ picture_px }) => picture_px.some((piece) => piece.length));
  svg.replaceChildren(...seen.flatMap((shape) => drawn(shape, shape.picture_px, width / 80, [true, false])));
  say(svg, "In the picture", seen);
}

/// The road from above: forward is up, left is left. Ground views lie under it where there are any.
export class Ground {
  constructor(box, reach_m, area) {
    this.box = box;
    this.area = area;
    this.svg = box.querySelector("svg");
    this.reach_m = reach_m;
    this.half_m = Math.round(0.42 * (reach_m + BEHIND_M));
    const [width, height] = [2 * this.half_m, reach_m + BEHIND_M];
    this.svg.setAttribute("viewBox", `${-this.half_m} ${-reach_m} ${width} ${height}`);
    box.style.aspectRatio = `${width} / ${height}`;
    box.style.maxWidth = `${(80 * width) / height}vh`;
    this.svg.classList.toggle("on-picture", !!area);
    this.shapes = svgElement("g");
    this.svg.replaceChildren(this.grid(), this.shapes);
  }

  /// Lines every five metres and the vehicle, whose rear axle is the origin.
  grid() {
    const { half_m, reach_m } = this;
    const back = svgElement("g", { "aria-hidden": "true" });
    const line = (x1, y1, x2, y2) => back.append(svgElement("line", { class: "grid", x1, y1, x2, y2 }));
    for (let x = -Math.floor(half_m / 5) * 5; x <= half_m; x += 5) line(x, BEHIND_M, x, -reach_m);
    this.size_m = reach_m / 30;
    for (let ahead = 0; ahead < reach_m; ahead += 5) {
      line(-half_m, -ahead, half_m, -ahead);
      if (ahead) back.append(svgElement("text", { x: 0.2 - half_m, y: -ahead - 0.2, "font-size": this.size_m }, `${ahead} m`));
    }
    back.append(svgElement("rect", { class: "vehicle", x: -0.9, y: -3.5, width: 1.8, height: 4.4, rx: 0.4 }));
    return back;
  }

  /// Lays pictures of the area where they belong, each over the one before; without any the last go.
  lay(views) {
    for (const image of this.box.querySelectorAll("img")) image.remove();
    if (!this.area) return;
    const { near_m, far_m, half_width_m } = this.area;
    const [width, height] = [2 * this.half_m, this.reach_m + BEHIND_M];
    const share = (metres, of) => `${(100 * metres) / of}%`;
    const place = { left: share(this.half_m - half_width_m, width), top: share(this.reach_m - far_m, height) };
    for (const view of views) {
      Object.assign(view.style, place, { width: share(2 * half_width_m, width), height: share(far_m - near_m, height) });
      view.alt = "";
    }
    this.box.prepend(...views);
  }

  draw(shapes) {
    const known = shapes.filter(({ ground_m }) => ground_m.length);
    const places = (shape) => [shape.ground_m.map(([forward, left]) => [-left, -forward])];
    const rims = this.area ? [true, false] : [false];
    this.shapes.replaceChildren(...known.flatMap((shape) => drawn(shape, places(shape), 0.6 * this.size_m, rims)));
    say(this.svg, "The road from above", known);
  }
}

/// Boxes that show and hide a kind.
export function legend(box, changed) {
  for (const [kind, name] of Object.entries(KINDS)) {
    const check = element("input", { type: "checkbox", checked: true });
    check.dataset.kind = kind;
    check.addEventListener("change", changed);
    box.append(element("label", {}, check, element("i", { className: kind }), name));
  }
  return (shapes) => shapes.filter(({ kind }) => box.querySelector(`input[data-kind="${kind}"]`).checked);
}
