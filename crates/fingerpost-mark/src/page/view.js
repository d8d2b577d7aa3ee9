// The picture on the canvas: where it lies, and what is drawn over it. Knows nothing of marks but points and curves.

export const COLOURS = { left: "#56b4e9", right: "#f09f1e" };
const HANDLE_PX = 5;

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.scale = 0;
    this.x = 0;
    this.y = 0;
  }

  /// Fits the canvas to its place on the page; the picture is shown whole the first time, and where it was.
  resize([width, height]) {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.canvas;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    this.ratio = ratio;
    const { scale, x, y } = this.whole ?? this;
    if (this.scale === scale && this.x === x && this.y === y) this.showAll([width, height]);
  }

  showAll([width, height]) {
    this.scale = Math.min(this.canvas.clientWidth / width, this.canvas.clientHeight / height);
    this.x = (this.canvas.clientWidth - width * this.scale) / 2;
    this.y = (this.canvas.clientHeight - height * this.scale) / 2;
    this.whole = { scale: this.scale, x: this.x, y: this.y };
  }

  zoom(at, factor) {
    const scale = Math.min(40, Math.max(0.05, this.scale * factor));
    this.x = at[0] - ((at[0] - this.x) * scale) / this.scale;
    this.y = at[1] - ((at[1] - this.y) * scale) / this.scale;
    this.scale = scale;
  }

  /// The picture's pixel at a place of the canvas: (0, 0) is the middle of the top-left pixel.
  pixel(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left - this.x) / this.scale - 0.5, (event.clientY - box.top - this.y) / this.scale - 0.5];
  }

  /// The other way.
  place([u, v]) {
    return [this.x + (u + 0.5) * this.scale, this.y + (v + 0.5) * this.scale];
  }

  /// Which of the points lies under the pointer; -1 for none.
  hit(points, event) {
    const box = this.canvas.getBoundingClientRect();
    const away = points.map((point) => {
      const [x, y] = this.place(point);
      return Math.hypot(x - (event.clientX - box.left), y - (event.clientY - box.top));
    });
    const nearest = away.indexOf(Math.min(...away));
    return away[nearest] <= 2 * HANDLE_PX ? nearest : -1;
  }

  draw(picture, edges, chosen) {
    const { context, ratio } = this;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (picture) {
      context.imageSmoothingEnabled = this.scale < 2;
      context.drawImage(picture, this.x, this.y, picture.naturalWidth * this.scale, picture.naturalHeight * this.scale);
    }
    for (const side of ["left", "right"]) this.drawEdge(edges[side], COLOURS[side], side === chosen);
  }

  drawEdge(edge, colour, chosen) {
    const { context } = this;
    if (!edge || edge.marked !== "present") return;
    context.lineJoin = "round";
    // A dark rim keeps the line in sight on bright paint.
    for (const [style, width] of [["rgba(0, 0, 0, 0.6)", 3], [colour, 1.25]]) {
      context.strokeStyle = style;
      context.lineWidth = width;
      context.setLineDash(edge.key ? [] : [7, 5]);
      context.beginPath();
      edge.curve_px.forEach((point, index) => context[index ? "lineTo" : "moveTo"](...this.place(point)));
      context.stroke();
    }
    context.setLineDash([]);
    for (const point of chosen ? edge.points_px : []) {
      const [x, y] = this.place(point);
      context.beginPath();
      context.arc(x, y, HANDLE_PX, 0, 2 * Math.PI);
      context.strokeStyle = "#000";
      context.lineWidth = 3;
      context.stroke();
      context.strokeStyle = colour;
      context.lineWidth = 1.5;
      context.stroke();
    }
  }
}

/// Key frames along the time line: a bar each, the left edge's above, hollow where there is no edge.
export function drawKeys(canvas, state, frame) {
  canvas.width = canvas.clientWidth;
  const context = canvas.getContext("2d");
  const last = Math.max(1, state.frames - 1);
  const x = (frame) => 8 + ((canvas.width - 16) * frame) / last;
  context.fillStyle = "#fff";
  context.fillRect(x(frame) - 0.5, 0, 1, canvas.height);
  ["left", "right"].forEach((side, row) => {
    for (const [key, present] of state[side]) {
      context.fillStyle = context.strokeStyle = COLOURS[side];
      const bar = [Math.round(x(key)) - 1.5, 1.5 + row * 11, 3, 8];
      present ? context.fillRect(...bar) : context.strokeRect(...bar);
    }
  });
}
