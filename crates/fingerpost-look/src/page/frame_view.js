// A frame of a run: the camera's picture with what was found in it, and the road from above.

import { Ground, drawOverlay } from "./shapes.js";

/// Nearest and farthest reach of the road from above, metres.
const REACH_M = [25, 60];

/// What is farthest ahead in the runs gives the reach of the road from above, so that it stays the same while stepping.
export function reach(runs) {
  const ahead = runs.flatMap((run) => run.curves.find(({ quantity }) => quantity === "forward").values);
  const farthest = ahead.reduce((a, b) => Math.max(a, b ?? 0), 0);
  const least = Math.max(REACH_M[0], ...runs.map((run) => run.ground_area?.far_m ?? 0));
  return Math.min(REACH_M[1], Math.max(least, 5 * Math.ceil(farthest / 5 + 0.4)));
}

export class FrameView {
  /// In a stage with a picture and an overlay, a place for what is missing, and one for the road from above.
  constructor({ stage, missing, ground }, run, reach_m) {
    Object.assign(this, { stage, missing, run });
    this.ground = new Ground(ground, reach_m, run.ground_area);
    this.shown = null;
  }

  /// Shows a frame of the run, by its number in the input.
  show(shown, number) {
    this.shown = shown;
    const before = this.stage.querySelector("img");
    const next = shown.picture || new Image();
    Object.assign(next, { id: before.id, alt: shown.picture ? `Camera's picture of frame ${number}` : "", hidden: !shown.picture });
    before.replaceWith(next);
    this.stage.querySelector(".classes")?.remove();
    if (shown.classes) next.after(Object.assign(shown.classes, { className: "classes", alt: "What the network sees in it" }));
    this.missing.textContent = shown.missing;
    this.ground.lay(shown.groundViews);
  }

  /// Draws those of the frame's shapes that are `chosen`.
  draw(chosen) {
    if (!this.shown) return;
    const { picture, shapes } = this.shown;
    const wanted = chosen(shapes);
    // Pixels of records are those of the picture as it was taken, whatever size it is shown in.
    const size = this.run.picture_px || (picture && [picture.naturalWidth, picture.naturalHeight]);
    this.stage.hidden = !size;
    if (size) {
      this.stage.style.aspectRatio = `${size[0]} / ${size[1]}`;
      drawOverlay(this.stage.querySelector("svg"), wanted, size);
    }
    this.ground.draw(wanted);
  }
}
