// The search for the mount in the whole drive: begun, followed and taken over.

import { $, element } from "./dom.js";
import { call, send } from "./frames.js";

/// How often it is asked how far the search is.
const ASK_MS = 100;

const pause = () => new Promise((done) => setTimeout(done, ASK_MS));

function show(state) {
  const runs = state.is === "running";
  $("search").disabled = runs;
  $("stop").hidden = $("progress").hidden = !runs;
  if (runs && state.of) Object.assign($("progress"), { max: state.of, value: state.frames });
  // Who has the page read aloud is told of the end, not of every frame.
  $("searching").textContent = runs ? `frame ${state.frames}${state.of ? ` of ${state.of}` : ""}` : "";
  const end = { running: [], idle: ["Stopped: the mount is as it was."], failed: [state.cause], found: state.said }[state.is];
  $("searched").replaceChildren(...end.map((text) => element("p", {}, text)));
  document.body.dataset.search = state.is;
}

/// Follows a search to its end, whoever began it; what is found goes to `found`.
async function follow(state, found) {
  try {
    while (state.is === "running") {
      show(state);
      await pause();
      state = await call("api/search");
    }
    if (state.is === "found") found(state.mount);
    show(state);
  } catch (cause) {
    show({ is: "failed", cause: cause.message });
  }
}

/// The button begins a search about `mount()`; one that goes on already, as after a reload, is followed.
export async function searchWith(mount, found) {
  const fail = (cause) => show({ is: "failed", cause: cause.message });
  $("search").addEventListener("click", () => send("api/search", mount()).then((state) => follow(state, found), fail));
  $("stop").addEventListener("click", () => send("api/search/stop", {}).catch(() => {}));
  const state = await call("api/search");
  if (state.is === "running") follow(state, found);
}
