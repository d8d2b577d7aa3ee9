// Settings moved, and the last seconds up to a frame run again with them: each stage before and after.

import { KEY_NUMBERS, columns, differing, reasons } from "./columns.js";
import { $, element } from "./dom.js";
import { Frames, call, linkParts, picture, send } from "./frames.js";
import { Settings } from "./settings.js";

let run = null;
let frames = null;
let feelable = null;
let settings = null;
let index = 0;
let lastMoved = null;
let running = false;
let isStale = false;
let opened = false;

const say = (text) => ($("message").textContent = text);

/// One stage's picture under a name; of a stage that is not there, that.
async function shot(stage, name) {
  const image = stage?.picture && (await picture(stage.picture)).picture;
  if (image) image.alt = `${stage.name}, ${name}: ${stage.legend}`;
  const nothing = element("p", { className: "hint", textContent: "not there" });
  const whole = image && element("a", { href: stage.picture, target: "_blank", title: "In full size, in a tab of its own" }, image);
  return element("figure", {}, whole || nothing, element("figcaption", { textContent: name }));
}

/// A stage before and after, or once where both are the same.
async function drawStage(name, stages) {
  const [before, after] = stages;
  const isSame = before && after && !after.picture;
  const names = isSame ? ["before and after: the same picture"] : ["before", "after"].slice(0, stages.length);
  const shots = names.map((when, index) => shot(stages[index], when));
  const about = element("details", {}, element("summary", {}, "what it shows"), (before ?? after).legend);
  const article = element("article", { className: "stage" }, element("h3", { textContent: name }));
  article.append(element("div", { className: "shots" }, ...(await Promise.all(shots))), about);
  article.dataset.same = isSame;
  return article;
}

async function drawStages({ before, after }) {
  const stretches = after ? [before, after] : [before];
  const names = [...new Set(stretches.flatMap(({ stages }) => stages.map(({ name }) => name)))];
  const drawn = names.map((name) => drawStage(name, stretches.map(({ stages }) => stages.find((stage) => stage.name === name))));
  $("stages").replaceChildren(...(await Promise.all(drawn)));
}

function drawNumbers({ before, after }, recorded) {
  const names = ["in the run", "before", ...(after ? ["after"] : [])];
  const records = [recorded, before.record, ...(after ? [after.record] : [])];
  const more = differing(before.record, after?.record, KEY_NUMBERS);
  const rest = element("details", { open: opened }, element("summary", { textContent: `${more.length} other numbers differ` }), columns(names, records, more, [1, 2]));
  rest.addEventListener("toggle", () => (opened = rest.open));
  $("numbers").replaceChildren(columns(names, records, KEY_NUMBERS, [1, 2]), ...reasons(names, records), ...(more.length ? [rest] : []));
}

function drawBeginning({ frame, duration_s, frames, route_m }) {
  const place = route_m ? `, ${route_m[0].toFixed(1)} m along the route with a standard deviation of ${route_m[1].toFixed(1)} m by the run's record` : "";
  $("beginning").textContent =
    `"Before" and "after" begin at frame ${frame}, ${duration_s.toFixed(1)} s or ${frames} frames back${place}, and know nothing of what was before it: ` +
    `neither the road's surface nor the camera's direction. GPS, the vehicle's bus, the map and known surfaces are left out. So "before", with the run's own settings, may differ from the run.`;
}

/// Where what is changed is kept over a reload: another run on the same port begins with its own settings.
const tried = () => `feel ${run.title} ${JSON.stringify(feelable.values)}`;

function drawChanged() {
  const keys = Object.keys(settings.changed);
  $("changed").replaceChildren();
  sessionStorage.setItem(tried(), JSON.stringify(settings.changed));
  if (!keys.length) return;
  const clear = element("button", { textContent: "Reset all" });
  clear.addEventListener("click", () => settings.replace({}));
  const save = element("button", { id: "save", textContent: "Save" });
  save.addEventListener("click", () => keep().catch(refuse));
  $("changed").append(element("p", {}, `${keys.length} changed: ${keys.join(", ")}`), save, " ", clear, element("p", { id: "saved", className: "hint" }));
}

async function keep() {
  const { file, command } = await send("api/feel/saved", settings.changed);
  $("saved").replaceChildren(`Saved in ${file}: what differs from the defaults. The drive is run with it by:`, element("pre", { textContent: command, tabIndex: 0 }));
}

/// An error is said at its setting: the one that is named, or else the one that was moved last.
function refuse(cause) {
  const isSaid = settings.refuse(cause.key ?? lastMoved, cause.message);
  say(isSaid ? "" : cause.message);
  document.body.dataset.refused = cause.key ?? lastMoved ?? "";
}

/// Runs the stretch again as settings and frame are at last: while one is run others may come and go.
async function feel() {
  isStale = true;
  if (running) return;
  running = true;
  while (isStale) {
    isStale = false;
    const since = performance.now();
    const changed = { ...settings.changed };
    const of = index;
    linkParts(run.frames[of]);
    try {
      const [felt, { record }] = await Promise.all([send(`api/feel/records/${of}`, changed), call(`api/records/${of}`)]);
      drawNumbers(felt, record);
      drawBeginning(felt.beginning);
      await drawStages(felt);
      settings.refuse(null, "");
      say("");
      delete document.body.dataset.refused;
      document.body.dataset.felt = JSON.stringify({ frame: run.frames[of], changed, ms: performance.now() - since });
    } catch (cause) {
      refuse(cause);
    }
  }
  running = false;
}

function go(wanted) {
  index = Math.min(frames.length - 1, Math.max(0, Number.isFinite(wanted) ? wanted : 0));
  $("seek").value = index;
  $("frame").value = run.frames[index];
  $("status").textContent = `frame ${run.frames[index]} (${index + 1} of ${frames.length}), ${run.times_s[index].toFixed(2)} s`;
  feel();
}

/// What a search has found: a click takes a point over in place of all that is changed.
function listPoints(points) {
  $("points").hidden = !points.length;
  for (const { name, results, settings: found } of points) {
    const words = Object.entries(found).map(([key, value]) => `${key} ${value}`).join(", ");
    const button = element("button", { className: "point" }, element("b", { textContent: name }), ` ${results}`, element("span", { className: "hint", textContent: words }));
    button.addEventListener("click", () => settings.replace(found));
    $("points").append(button);
  }
}

async function begin() {
  run = await call("api/run");
  frames = new Frames(run);
  document.title = `Fingerpost: ${run.title}`;
  $("title").textContent = run.title;
  $("seek").max = frames.length - 1;
  $("frame").max = run.frames[frames.length - 1];
  $("back").addEventListener("click", () => go(index - 1));
  $("forward").addEventListener("click", () => go(index + 1));
  $("frame").addEventListener("change", () => go(frames.indexOf($("frame").valueAsNumber)));
  $("seek").addEventListener("input", () => go($("seek").valueAsNumber));
  addEventListener("hashchange", () => go(frames.linked()));
  feelable = await call("api/feel/settings");
  settings = new Settings($("tables"), feelable, (key) => {
    lastMoved = key;
    drawChanged();
    feel();
  });
  listPoints(feelable.points);
  $("search").addEventListener("input", () => settings.search($("search").value));
  index = frames.linked();
  settings.replace(JSON.parse(sessionStorage.getItem(tried()) ?? "{}"));
  settings.search("");
  go(index);
  document.body.dataset.ready = "yes";
}
begin().catch((cause) => say(cause.message));
