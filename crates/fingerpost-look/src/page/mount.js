// A drive set up: a mount changed by dragging, by sliders and by calibration, and the start of a route. Horizon, grid, ground view and what of
// the route is seen, the program says.

import { $, element } from "./dom.js";
import { call, picture, send } from "./frames.js";
import { RouteMap } from "./route_map.js";
import { searchWith } from "./search.js";
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
/// What of the map is drawn on it.
const ON_GROUND = ["road", "route", "feature"];

const inputs = {};
let drive = null;
let ground = null;
let mount = null;
let map = null;
let start_m = null;
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
    // The start is that of the first frame; how far the vehicle has come in another is not known.
    const start = map && frame === 0 ? `/starts/${start_m}` : "";
    try {
      const asked = { ...mount, start_m, frame };
      const coming = picture(`${path}/frames/${frame}`);
      const shapes = await call(`${path}${start}/shapes`);
      drawOverlay($("overlay"), shapes, drive.picture_px);
      const view = await coming;
      ground.lay(view.picture ? [view.picture] : []);
      ground.draw(shapes.filter(({ kind }) => ON_GROUND.includes(kind)));
      say(view.missing);
      const ms = performance.now() - since;
      document.body.dataset.drawn = JSON.stringify({ ...asked, ms });
    } catch (cause) {
      say(cause.message);
    }
  }
  drawing = false;
}

function redraw() {
  $("kept").textContent = "";
  $("command").hidden = true;
  draw();
}

function change(numbers) {
  for (const [name, value] of Object.entries(numbers)) {
    if (!Number.isFinite(value)) continue;
    mount[name] = Math.round(value * 1e4) / 1e4;
    const [slider] = inputs[name];
    slider.min = Math.min(slider.min, mount[name]);
    slider.max = Math.max(slider.max, mount[name]);
    for (const input of inputs[name]) if (input !== document.activeElement || input.type === "range") input.value = mount[name];
  }
  redraw();
}

function moveStart(wanted_m) {
  if (!Number.isFinite(wanted_m)) return;
  start_m = Math.floor(Math.max(0, Math.min(map.length_m, wanted_m)) * 10) / 10;
  for (const input of [$("start"), $("start-slider")]) if (input !== document.activeElement || input.type === "range") input.value = start_m;
  map.show(start_m);
  redraw();
}

function showRoute() {
  document.querySelector("main").classList.add("with-route");
  $("route").hidden = false;
  map = new RouteMap($("map"), drive.route.map, moveStart);
  for (const input of [$("start"), $("start-slider")]) {
    input.max = map.length_m;
    input.addEventListener("input", () => moveStart(input.valueAsNumber));
  }
  arrows($("start-slider"), 0.5, (by) => moveStart(start_m + by));
  $("nearer").addEventListener("click", () => map.zoomBy(-1));
  $("farther").addEventListener("click", () => map.zoomBy(1));
  moveStart(drive.route.start_m);
}

/// Arrows of a slider go by the same steps as the number's.
function arrows(slider, step, move) {
  slider.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -step, ArrowDown: -step, ArrowRight: step, ArrowUp: step }[event.key];
    if (!by) return;
    event.preventDefault();
    move(by);
  });
}

function makeInputs() {
  for (const [name, [words, about, step]] of Object.entries(NUMBERS)) {
    const least = name === "height_m" ? Math.max(0.1, mount[name] - about) : mount[name] - about;
    // A file may have more digits than there is room for.
    const value = Math.round(mount[name] * 1e4) / 1e4;
    const range = { min: least.toFixed(2), max: (mount[name] + about).toFixed(2), step, value };
    const slider = element("input", { type: "range", ...range, step: "any", id: `${name}-slider` });
    slider.setAttribute("aria-label", `${words}, by slider`);
    const number = element("input", { type: "number", step, value, id: name });
    for (const input of [slider, number]) input.addEventListener("input", () => change({ [name]: input.valueAsNumber }));
    arrows(slider, step, (by) => change({ [name]: mount[name] + by }));
    $("numbers-of-mount").append(element("label", {}, words, number), slider);
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
  $("first-alone").hidden = frame === 0;
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
$("again").addEventListener("click", () => {
  change(drive.mount);
  if (map) moveStart(drive.route.start_m);
});
$("keep").addEventListener("click", async () => {
  try {
    const kept = await send("api/set_up", { mount, start_m });
    $("kept").textContent = `Saved in ${kept.files.join(" and ")}. The drive is run with it by:`;
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
  // The height is not searched for, and may have been changed meanwhile.
  await searchWith(() => mount, ({ height_m, ...angles }) => change(angles));
  if (drive.route) showRoute();
  await show(0);
  document.body.dataset.ready = "yes";
}
begin().catch((cause) => say(cause.message));
