// A mount changed by dragging and by sliders; horizon, grid and ground view of it, the program says.

import { call, picture } from "./frames.js";
import { Ground, drawOverlay } from "./shapes.js";

/// The mount's numbers: what people call them, and how far and how finely a slider goes about where it began.
const NUMBERS = {
  height_m: ["height, m above the road", 0.8, 0.01],
  pitch_deg: ["pitch, degrees, positive nose down", 8, 0.05],
  yaw_deg: ["yaw, degrees, positive left", 8, 0.05],
  roll_deg: ["roll, degrees, positive left side up", 6, 0.05],
};
/// How far the road from above reaches, metres.
const REACH_M = 25;

const $ = (id) => document.getElementById(id);
const inputs = {};
let drive = null;
let ground = null;
let mount = null;
let frame = 0;
let drawing = false;
let isStale = false;

const say = (text) => ($("message").textContent = text);
const degrees = (rad) => (rad * 180) / Math.PI;

/// Draws the mount as it is at last: while one is drawn others may come and go.
async function draw() {
  isStale = true;
  if (drawing) return;
  drawing = true;
  while (isStale) {
    isStale = false;
    const since = performance.now();
    const path = `api/mounts/${Object.keys(NUMBERS).map((name) => mount[name]).join(",")}`;
    try {
      const [shapes, view] = await Promise.all([call(`${path}/shapes`), picture(`${path}/frames/${frame}`)]);
      drawOverlay($("overlay"), shapes, drive.picture_px);
      ground.lay(view.picture);
      say(view.missing);
      const ms = performance.now() - since;
      document.body.dataset.drawn = JSON.stringify({ ...mount, frame, ms });
    } catch (cause) {
      say(cause.message);
    }
  }
  drawing = false;
}

function change(numbers) {
  for (const [name, value] of Object.entries(numbers)) {
    if (!Number.isFinite(value)) continue;
    mount[name] = Math.round(value * 1e4) / 1e4;
    for (const input of inputs[name]) if (input !== document.activeElement || input.type === "range") input.value = mount[name];
  }
  $("kept").textContent = "";
  $("command").hidden = true;
  draw();
}

function makeInputs() {
  for (const [name, [words, about, step]] of Object.entries(NUMBERS)) {
    const least = name === "height_m" ? Math.max(0.1, mount[name] - about) : mount[name] - about;
    const range = { min: least.toFixed(2), max: (mount[name] + about).toFixed(2), step, value: mount[name] };
    const slider = Object.assign(document.createElement("input"), { type: "range", ...range, step: "any", id: `${name}-slider` });
    slider.setAttribute("aria-label", `${words}, by slider`);
    const number = Object.assign(document.createElement("input"), { type: "number", step, value: mount[name], id: name });
    for (const input of [slider, number]) input.addEventListener("input", () => change({ [name]: input.valueAsNumber }));
    // Arrows go by the same steps as the number's.
    slider.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -step, ArrowDown: -step, ArrowRight: step, ArrowUp: step }[event.key];
      if (!by) return;
      event.preventDefault();
      change({ [name]: mount[name] + by });
    });
    const label = document.createElement("label");
    label.append(words, number);
    $("numbers-of-mount").append(label, slider);
    inputs[name] = [slider, number];
  }
}

/// The number of the last frame that is shown.
const last = () => drive.frame_step * (drive.frames - 1);

async function show(wanted) {
  const { frames, frame_step } = drive;
  frame = frame_step * Math.min(frames - 1, Math.max(0, Number.isFinite(wanted) ? Math.round(wanted / frame_step) : 0));
  $("frame").value = $("seek").value = frame;
  const mine = frame;
  const shown = await picture(`api/frames/${frame}/picture`);
  if (mine !== frame) return;
  const next = shown.picture || new Image();
  Object.assign(next, { id: "picture", alt: shown.picture ? `Camera's picture of frame ${frame}` : "", hidden: !shown.picture });
  $("picture").replaceWith(next);
  $("no-picture").textContent = shown.missing;
  $("status").textContent = `frame ${frame}; the last is ${last()}`;
  await draw();
}

let drag = null;
$("stage").addEventListener("pointerdown", (event) => {
  event.preventDefault();
  $("stage").setPointerCapture(event.pointerId);
  drag = { from: [event.clientX, event.clientY], mount: { ...mount } };
});
$("stage").addEventListener("pointermove", (event) => {
  if (!drag) return;
  const scale = drive.picture_px[0] / $("stage").clientWidth;
  const [du, dv] = [(event.clientX - drag.from[0]) * scale, (event.clientY - drag.from[1]) * scale];
  // What is dragged follows the pointer: down is a nose that goes up.
  change({
    pitch_deg: drag.mount.pitch_deg - degrees(Math.atan(dv / drive.focal_px[1])),
    yaw_deg: drag.mount.yaw_deg + degrees(Math.atan(du / drive.focal_px[0])),
  });
});
for (const end of ["pointerup", "pointercancel"]) $("stage").addEventListener(end, () => (drag = null));

$("seek").addEventListener("input", () => show($("seek").valueAsNumber));
$("frame").addEventListener("change", () => show($("frame").valueAsNumber));
$("again").addEventListener("click", () => change(drive.mount));
$("keep").addEventListener("click", async () => {
  try {
    const headers = { "Content-Type": "application/json" };
    const answer = await fetch("api/camera", { method: "POST", headers, body: JSON.stringify(mount) });
    const kept = await answer.json();
    if (!answer.ok) throw new Error(kept.error);
    $("kept").textContent = `Saved in ${kept.file}. The drive is run with it by:`;
    $("command").textContent = kept.command;
    $("command").hidden = false;
  } catch (cause) {
    say(cause.message);
  }
});

async function begin() {
  drive = await call("api/drive");
  mount = { ...drive.mount };
  document.title = `Fingerpost: ${drive.title}`;
  $("title").textContent = drive.title;
  $("seek").max = $("frame").max = last();
  $("seek").step = $("frame").step = drive.frame_step;
  $("stage").style.aspectRatio = drive.picture_px.join(" / ");
  ground = new Ground($("ground"), REACH_M, drive.ground_area);
  makeInputs();
  await show(0);
  document.body.dataset.ready = "yes";
}
begin().catch((cause) => say(cause.message));
