// Two runs of one drive, frame by frame, and the frames in which they differ most.

import { KEY_NUMBERS, columns, differing, leaves, reasons } from "./columns.js";
import { Curves } from "./curves.js";
import { $, element, svgElement } from "./dom.js";
import { Frames, call, linkParts } from "./frames.js";
import { FrameView, reach } from "./frame_view.js";
import { legend } from "./shapes.js";

let differences = null;
/// The frames that both have: their numbers and times.
let common = null;
let sides = [];
let names = [];
let curves = null;
let chosen = null;
let index = 0;
let asked = 0;

const say = (text) => ($("message").textContent = text);

/// What shows one run's frame.
function makeSide(name, run, frames, reach_m) {
  const svg = svgElement("svg", { class: "on-picture", role: "img" });
  const stage = element("div", { className: "camera-stage" }, new Image(), svg);
  const roadSvg = svg.cloneNode();
  roadSvg.removeAttribute("class");
  const ground = element("div", { className: "ground" }, roadSvg);
  const missing = element("p", { className: "hint" });
  $("runs").append(element("section", {}, element("h2", { textContent: name }), stage, missing, ground));
  return { frames, view: new FrameView({ stage, missing, ground }, run, reach_m) };
}

function drawShapes() {
  for (const { view } of sides) view.draw(chosen);
}

function showNumbers(records) {
  const more = differing(...records, KEY_NUMBERS);
  const rest = element("details", {}, element("summary", { textContent: `${more.length} other numbers differ` }), columns(names, records, more, [0, 1]));
  $("numbers").replaceChildren(columns(names, records, KEY_NUMBERS, [0, 1]), ...reasons(names, records), ...(more.length ? [rest] : []));
}

async function go(wanted) {
  index = Math.min(common.length - 1, Math.max(0, Number.isFinite(wanted) ? wanted : 0));
  const number = differences.frames[index];
  $("seek").value = index;
  $("frame").value = number;
  const mine = ++asked;
  const found = await Promise.all(sides.map(({ frames }, side) => frames.get(differences.indices[index][side])));
  // A later step has overtaken this one.
  if (mine !== asked) return;
  say("");
  sides.forEach(({ view }, side) => view.show(found[side], number));
  drawShapes();
  showNumbers(found.map(({ record }) => record));
  curves.show(index);
  const last = differences.events.findLastIndex((event) => event.index <= index);
  $("events").querySelector("[aria-current]")?.removeAttribute("aria-current");
  $("events").children[last]?.querySelector("button")?.setAttribute("aria-current", "true");
  $("status").textContent = `frame ${number} (${index + 1} of ${common.length} that both have), ${differences.times_s[index].toFixed(2)} s`;
  linkParts(number);
  document.body.dataset.frame = number;
}

function step(wanted) {
  go(wanted).catch((cause) => say(cause.message));
}

function event(direction) {
  const { events } = differences;
  const found = direction < 0 ? events.findLast((event) => event.index < index) : events.find((event) => event.index > index);
  if (found) step(found.index);
}

function listEvents() {
  for (const { index, frame, kind, text } of differences.events) {
    const button = element("button", { textContent: `${differences.times_s[index].toFixed(1)} s, frame ${frame}: ${text}` });
    button.addEventListener("click", () => step(index));
    $("events").append(element("li", { className: kind }, button));
  }
  if (!differences.events.length) $("events").append(element("li", { textContent: "Nowhere: no number that is held against another differs." }));
}

function showSummaries(runs) {
  const summaries = runs.map((run) => run.summary);
  const keys = [...new Set(summaries.flatMap((summary) => (summary ? leaves(summary) : [])).map(([key]) => key))];
  const settings = [0, 1].map((side) => Object.fromEntries(differences.settings.map(([key, pair]) => [key, pair[side]])));
  const changed = differences.settings.map(([key]) => key);
  $("summaries").append(
    element("h3", { textContent: changed.length ? "Settings that differ" : "No setting is known to differ." }),
    columns(names, settings, changed, []),
    element("h3", { textContent: "What differs in the summaries, times of stages aside" }),
    columns(names, summaries, differing(...summaries, []), []),
    element("details", {}, element("summary", { textContent: "all of summary.json" }), columns(names, summaries, keys, [0, 1])),
  );
}

const actions = {
  back: () => step(index - 1),
  forward: () => step(index + 1),
  "event-before": () => event(-1),
  "event-after": () => event(1),
};

addEventListener("keydown", (event) => {
  if (!common || event.target === $("frame") || event.ctrlKey || event.metaKey || event.altKey) return;
  const many = event.shiftKey ? 10 : 1;
  const keys = { ArrowLeft: () => step(index - many), ArrowRight: () => step(index + many), n: actions["event-after"], p: actions["event-before"] };
  const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
});

async function begin() {
  differences = await call("api/differences");
  const runs = await Promise.all([call("api/run"), call("api/other/run")]);
  common = new Frames(differences);
  names = runs[0].title === runs[1].title ? [runs[0].title, `${runs[1].title} (other)`] : runs.map((run) => run.title);
  document.title = `Fingerpost: ${names.join(" and ")}`;
  $("title").textContent = names.join(" and ");
  const reach_m = reach(runs);
  sides = runs.map((run, side) => makeSide(names[side], run, new Frames(run, ["api", "api/other"][side]), reach_m));
  curves = new Curves($("curves"), differences, (time_s) => step(common.indexAt(time_s)));
  chosen = legend($("legend"), drawShapes);
  listEvents();
  showSummaries(runs);
  $("seek").max = common.length - 1;
  $("frame").max = differences.frames[common.length - 1];
  for (const [id, action] of Object.entries(actions)) $(id).addEventListener("click", action);
  $("frame").addEventListener("change", () => step(common.indexOf($("frame").valueAsNumber)));
  $("seek").addEventListener("input", () => step($("seek").valueAsNumber));
  addEventListener("hashchange", () => step(common.linked()));
  await go(common.linked());
  document.body.dataset.ready = "yes";
}
begin().catch((cause) => say(cause.message));
