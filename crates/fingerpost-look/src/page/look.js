// Steps through the run; what is to be seen in a frame, the program says.

import { Curves } from "./curves.js";
import { FixMap } from "./fix_map.js";
import { $, element } from "./dom.js";
import { Frames, call, linkParts } from "./frames.js";
import { FrameView, reach } from "./frame_view.js";
import { showNumbers } from "./numbers.js";
import { legend } from "./shapes.js";

/// A browser takes so many changes of an address in a time; the link of a frame that is passed over is wanted by nobody.
const LINK_AFTER_MS = 250;

/// Pictures beside those that each frame has, with the part of the page that has their box.
const LAYERS = { road_surface: "surface", classes: "classes" };
const opened = new Set();
let run = null;
let frames = null;
let curves = null;
let view = null;
let map = null;
let chosen = null;
let index = 0;
let shown = null;
let asked = 0;
let linking = 0;
let eventButtons = [];

function say(text) {
  $("message").textContent = text;
}

function drawShapes() {
  view.draw(chosen);
}

/// Marks the last event so far, and brings it into sight where it is another than before.
function showEvents() {
  const last = run.events.findLastIndex((event) => event.index <= index);
  const button = eventButtons[last];
  const before = $("events").querySelector("[aria-current]");
  if (button === before) return;
  before?.removeAttribute("aria-current");
  button?.setAttribute("aria-current", "true");
  const list = $("events");
  if (button) list.scrollTop = button.offsetTop - list.offsetTop - list.clientHeight / 2;
}

function show() {
  const { record } = shown;
  view.show(shown, run.frames[index]);
  drawShapes();
  curves.show(index);
  map?.show(index, record.fix);
  showEvents();
  showNumbers($("numbers"), "frame", record, opened);
  $("why").textContent = record.why;
  const state = record.state.replace("_", " ");
  $("status").textContent = `frame ${record.frame} (${index + 1} of ${frames.length}), ${record.t_s.toFixed(2)} s, ${state}`;
  document.body.dataset.frame = record.frame;
}

async function go(wanted) {
  index = Math.min(frames.length - 1, Math.max(0, Number.isFinite(wanted) ? wanted : 0));
  $("seek").value = index;
  $("frame").value = run.frames[index];
  clearTimeout(linking);
  linking = setTimeout(() => linkParts(run.frames[index]), LINK_AFTER_MS);
  const mine = ++asked;
  const found = await frames.get(index);
  // A later step has overtaken this one.
  if (mine !== asked) return;
  shown = found;
  say("");
  show();
  frames.prepare(index);
}

function step(wanted) {
  go(wanted).catch((cause) => say(cause.message));
}

function event(direction) {
  const found =
    direction < 0 ? run.events.findLast((event) => event.index < index) : run.events.find((event) => event.index > index);
  if (found) step(found.index);
}

function listEvents() {
  eventButtons = run.events.map(({ index, frame, kind, text }) => {
    const button = element("button", {}, `${run.times_s[index].toFixed(1)} s, frame ${frame}: ${text}`);
    button.addEventListener("click", () => step(index));
    $("events").append(element("li", { className: kind }, button));
    return button;
  });
  const nothing = "Nothing: no feature was found, lost or in doubt, and the camera was clear.";
  if (!run.events.length) $("events").append(element("li", {}, nothing));
}

function showRun() {
  document.title = `Fingerpost: ${run.title}`;
  $("title").textContent = run.title;
  $("seek").max = frames.length - 1;
  $("frame").max = run.frames[frames.length - 1];
  $("summary").hidden = !run.summary;
  $("settings").hidden = !run.config_toml;
  $("run").hidden = !run.summary && !run.config_toml;
  if (run.summary) showNumbers($("summary").querySelector("div"), "run", run.summary, opened);
  $("settings").querySelector("pre").textContent = run.config_toml;
}

/// Asks for the layers whose boxes are ticked.
function changeLayers() {
  frames.askFor(Object.keys(LAYERS).filter((layer) => $(LAYERS[layer]).querySelector("input")?.checked));
  step(index);
}

/// What the network's colours say, and a box that lays them over the picture; or why there are none.
function showClasses({ legend, lacking }) {
  $("classes").classList.toggle("hint", !legend.length);
  if (!legend.length) return $("classes").append(lacking ?? "");
  const box = element("label", {}, element("input", { type: "checkbox" }), " what the network sees:");
  const names = legend.map(({ name, colour }) => {
    const swatch = element("i");
    swatch.style.background = colour;
    return element("span", {}, swatch, name);
  });
  $("classes").append(box, ...names);
}

const actions = {
  back: () => step(index - 1),
  forward: () => step(index + 1),
  "event-before": () => event(-1),
  "event-after": () => event(1),
};
for (const [id, action] of Object.entries(actions)) $(id).addEventListener("click", action);
$("frame").addEventListener("change", () => step(frames.indexOf($("frame").valueAsNumber)));
$("seek").addEventListener("input", () => step($("seek").valueAsNumber));
for (const id of Object.values(LAYERS)) $(id).addEventListener("change", changeLayers);
addEventListener("hashchange", () => step(frames.linked()));

addEventListener("keydown", (event) => {
  if (!run || event.target === $("frame") || event.ctrlKey || event.metaKey || event.altKey) return;
  const many = event.shiftKey ? 10 : 1;
  const keys = {
    ArrowLeft: () => step(index - many),
    ArrowRight: () => step(index + many),
    Home: () => step(0),
    End: () => step(frames.length - 1),
    n: actions["event-after"],
    p: actions["event-before"],
  };
  const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
});

function showMap() {
  $("place").hidden = false;
  $("of-osm").hidden = !run.map.route;
  map = new FixMap($("map"), $("fix"), run.map);
  $("nearer").addEventListener("click", () => map.zoomBy(-1));
  $("farther").addEventListener("click", () => map.zoomBy(1));
}

async function begin() {
  run = await call("api/run");
  frames = new Frames(run);
  curves = new Curves($("curves"), run, (time_s) => step(frames.indexAt(time_s)));
  view = new FrameView({ stage: $("stage"), missing: $("no-picture"), ground: $("ground") }, run, reach([run]));
  chosen = legend($("legend"), drawShapes);
  $("surface").hidden = !run.has_road_surfaces;
  showClasses(run.classes);
  if (run.map) showMap();
  listEvents();
  showRun();
  await go(frames.linked());
  document.body.dataset.ready = "yes";
}
begin().catch((cause) => say(cause.message));
