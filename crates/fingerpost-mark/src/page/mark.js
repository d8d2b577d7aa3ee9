// Shows frames and their edges and sends edits; what an edge is in a frame, the program says.

import { View, drawKeys } from "./view.js";

const $ = (id) => document.getElementById(id);
const view = new View($("canvas"));
// For tests, which click on pixels of the picture.
window.markView = view;
let state = null;
let frame = 0;
let edges = { left: null, right: null };
let side = "left";
let picture = null;
let drag = null;
let asked = 0;

async function call(path, body) {
  const options = body === undefined ? {} : { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  const answer = await fetch(path, options);
  const data = await answer.json();
  if (!answer.ok) throw new Error(data.error);
  return data;
}

function say(text, bad = false) {
  $("message").textContent = text;
  $("message").classList.toggle("bad", bad);
}

/// One thing after the other, so that edits arrive in their order; what fails is said.
let queue = Promise.resolve();
function inTurn(work) {
  queue = queue.then(work).catch((cause) => say(cause.message, true));
  return queue;
}

function show() {
  view.draw(picture, edges, side);
  drawKeys($("keys"), state, frame);
  $("frame").value = $("seek").value = frame;
  $("left").classList.toggle("chosen", side === "left");
  $("right").classList.toggle("chosen", side === "right");
  $("undo").disabled = !state.can_undo;
  $("redo").disabled = !state.can_redo;
  const edge = edges[side];
  $("key").disabled = !edge || edge.key || edge.marked !== "present";
  $("clear").disabled = !edge || !edge.key;
  const words = { unmarked: "not marked", absent: "no edge", present: "marked" };
  const text = (name) => (edges[name] ? words[edges[name].marked] + (edges[name].key ? " (key)" : "") : "");
  $("edges").textContent = `left ${text("left")}, right ${text("right")}`;
}

function load(index) {
  return new Promise((resolve) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = () => resolve(null);
    image.src = `api/frames/${index}/picture`;
  });
}

async function go(index) {
  frame = Math.min(state.frames - 1, Math.max(0, Number.isFinite(index) ? index : 0));
  const mine = ++asked;
  const [found, shown] = await Promise.all([call(`api/frames/${frame}/edges`), load(frame)]);
  // A later step has overtaken this one.
  if (mine !== asked) return;
  edges = found;
  picture = shown;
  if (!shown) say(`the picture of frame ${frame} cannot be shown`, true);
  show();
}

function step(index) {
  go(index).catch((cause) => say(cause.message, true));
}

function take(data) {
  state = data.state;
  say("saved");
  if (data.frame === frame) {
    edges = data.edges;
    show();
    return undefined;
  }
  return go(data.frame);
}

function edit(points, of = side, at = frame) {
  return inTurn(async () => take(await call("api/edit", { side: of, frame: at, points_px: points })));
}

const points = () => (edges[side] && edges[side].marked === "present" ? edges[side].points_px : []);

function keyFrame(direction) {
  const keys = [...state.left, ...state.right].map(([key]) => key).sort((a, b) => a - b);
  const found = direction < 0 ? keys.findLast((key) => key < frame) : keys.find((key) => key > frame);
  if (found !== undefined) step(found);
}

/// The edge with other points, until the program has said what it is.
let previewed = 0;
function preview(next) {
  const mine = ++previewed;
  edges = { ...edges, [side]: { marked: "present", key: true, points_px: next, curve_px: [...next].sort((a, b) => b[1] - a[1]) } };
  show();
  call("api/curve", { points_px: next })
    .then(({ curve_px }) => {
      if (mine !== previewed || !drag) return;
      edges[side].curve_px = curve_px;
      show();
    })
    .catch(() => {});
}

$("canvas").addEventListener("pointerdown", (event) => {
  if (event.button === 2) return;
  $("canvas").setPointerCapture(event.pointerId);
  const index = event.button === 0 ? view.hit(points(), event) : -1;
  drag = { index, start: [event.clientX, event.clientY], from: [view.x, view.y], moved: false, points: points().map((p) => [...p]) };
});

$("canvas").addEventListener("pointermove", (event) => {
  if (!drag) return;
  const by = [event.clientX - drag.start[0], event.clientY - drag.start[1]];
  if (Math.hypot(...by) > 3) drag.moved = true;
  if (!drag.moved) return;
  if (drag.index < 0) {
    [view.x, view.y] = [drag.from[0] + by[0], drag.from[1] + by[1]];
    show();
  } else {
    drag.points[drag.index] = view.pixel(event);
    preview(drag.points);
  }
});

$("canvas").addEventListener("pointerup", (event) => {
  const done = drag;
  drag = null;
  previewed++;
  if (!done || event.button !== 0) return;
  if (done.index >= 0 && done.moved) edit(done.points);
  if (done.index < 0 && !done.moved) edit([...done.points, view.pixel(event)]);
});

$("canvas").addEventListener("pointercancel", () => {
  drag = null;
  step(frame);
});

$("canvas").addEventListener("contextmenu", (event) => {
  event.preventDefault();
  const index = view.hit(points(), event);
  const rest = points().filter((_, other) => other !== index);
  // An edge without points would say that there is no edge.
  if (index >= 0) edit(rest.length ? rest : null);
});

$("canvas").addEventListener(
  "wheel",
  (event) => {
    event.preventDefault();
    const box = $("canvas").getBoundingClientRect();
    view.zoom([event.clientX - box.left, event.clientY - box.top], Math.exp(-event.deltaY * 0.0015));
    show();
  },
  { passive: false },
);

const choose = (name) => {
  side = name;
  show();
};
const actions = {
  left: () => choose("left"),
  right: () => choose("right"),
  key: () => points().length && edit(points()),
  absent: () => edit([]),
  clear: () => edit(null),
  undo: () => inTurn(async () => take(await call("api/undo", {}))),
  redo: () => inTurn(async () => take(await call("api/redo", {}))),
  export: () => inTurn(async () => say(`written: ${(await call("api/export", {})).files.join(", ")}`)),
  back: () => step(frame - 1),
  forward: () => step(frame + 1),
  "key-before": () => keyFrame(-1),
  "key-after": () => keyFrame(1),
};
for (const [id, action] of Object.entries(actions)) $(id).addEventListener("click", action);
$("frame").addEventListener("change", () => step($("frame").valueAsNumber));
$("seek").addEventListener("input", () => step($("seek").valueAsNumber));

addEventListener("keydown", (event) => {
  const control = event.ctrlKey || event.metaKey;
  if (event.target === $("frame")) return;
  const ten = event.shiftKey ? 10 : 1;
  const keys = {
    ArrowLeft: () => step(frame - ten),
    ArrowRight: () => step(frame + ten),
    PageUp: () => keyFrame(-1),
    PageDown: () => keyFrame(1),
    Home: () => step(0),
    End: () => step(state.frames - 1),
    1: actions.left,
    2: actions.right,
    k: actions.key,
    n: actions.absent,
    Backspace: actions.clear,
    0: () => {
      view.showAll(state.picture_px);
      show();
    },
  };
  const chords = { z: event.shiftKey ? actions.redo : actions.undo, y: actions.redo };
  const action = (control ? chords : keys)[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
});

addEventListener("resize", () => {
  if (!state) return;
  view.resize(state.picture_px);
  show();
});

inTurn(async () => {
  state = await call("api/state");
  $("input").textContent = state.input;
  $("seek").max = $("frame").max = state.frames - 1;
  view.resize(state.picture_px);
  await go(0);
  document.body.dataset.ready = "yes";
});
