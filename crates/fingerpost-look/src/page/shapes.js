// Shapes of a frame over the camera's picture and on the road from above. What they are and where, the program says.

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

export function element(name, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/// One shape's pieces: a place as a ring, a line as it is, each on a dark rim where it lies on a picture.
function drawn({ kind, label }, pieces, ring, rims) {
  return pieces.flatMap((piece) =>
    rims.map((rim) => {
      const made =
        piece.length === 1
          ? element("circle", { cx: piece[0][0], cy: piece[0][1], r: ring })
          : element("polyline", { points: piece.map((place) => place.join(",")).join(" ") });
      made.setAttribute("class", rim ? "rim" : kind);
      made.dataset.kind = kind;
      made.append(element("title", {}, label));
      return made;
    }),
  );
}

function say(svg, what, shapes) {
  svg.setAttribute("aria-label", `${what}: ${shapes.map(({ label }) => label).join("; ") || "nothing"}`);
}

/// Draws over a picture of such a size; its top-left pixel's middle is (0, 0).
export function drawOverlay(svg, shapes, [width, height]) {
  svg.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
  const seen = shapes.filter(({ picture_px }) => picture_px.some((piece) => piece.length));
  svg.replaceChildren(...seen.flatMap((shape) => drawn(shape, shape.picture_px, width / 80, [true, false])));
  say(svg, "In the picture", seen);
}

/// The road from above: forward is up, left is left.
export class Ground {
  constructor(svg, reach_m) {
    this.svg = svg;
    const half_m = Math.round(0.42 * (reach_m + BEHIND_M));
    svg.setAttribute("viewBox", `${-half_m} ${-reach_m} ${2 * half_m} ${reach_m + BEHIND_M}`);
    this.size_m = reach_m / 30;
    const back = element("g", { "aria-hidden": "true" });
    for (let x = -Math.floor(half_m / 5) * 5; x <= half_m; x += 5) back.append(this.gridLine(x, BEHIND_M, x, -reach_m));
    for (let ahead = 0; ahead < reach_m; ahead += 5) {
      back.append(this.gridLine(-half_m, -ahead, half_m, -ahead));
      const text = element("text", { x: -half_m + 0.2, y: -ahead - 0.2, "font-size": this.size_m }, `${ahead} m`);
      if (ahead) back.append(text);
    }
    // A car about the rear axle, which is the origin.
    back.append(element("rect", { class: "vehicle", x: -0.9, y: -3.5, width: 1.8, height: 4.4, rx: 0.4 }));
    this.shapes = element("g");
    svg.replaceChildren(back, this.shapes);
  }

  gridLine(x1, y1, x2, y2) {
    return element("line", { class: "grid", x1, y1, x2, y2 });
  }

  draw(shapes) {
    const known = shapes.filter(({ ground_m }) => ground_m.length);
    const places = (shape) => [shape.ground_m.map(([forward, left]) => [-left, -forward])];
    this.shapes.replaceChildren(...known.flatMap((shape) => drawn(shape, places(shape), 0.6 * this.size_m, [false])));
    say(this.svg, "The road from above", known);
  }
}

/// Boxes that show and hide a kind.
export function legend(box, changed) {
  for (const [kind, name] of Object.entries(KINDS)) {
    const check = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
    check.dataset.kind = kind;
    check.addEventListener("change", changed);
    const swatch = Object.assign(document.createElement("i"), { className: kind });
    const label = document.createElement("label");
    label.append(check, swatch, name);
    box.append(label);
  }
  return (shapes) => shapes.filter(({ kind }) => box.querySelector(`input[data-kind="${kind}"]`).checked);
}
