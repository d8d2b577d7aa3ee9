// What the program says of a frame, asked for once and kept for a while.

/// Frames that are kept: some seconds of stepping to and fro.
const KEPT = 32;

export async function call(path, request) {
  const answer = await fetch(path, request);
  const data = await answer.json();
  if (!answer.ok) throw Object.assign(new Error(data.error), { key: data.key });
  return data;
}

/// Sends data, and gives the answer.
export function send(path, data) {
  return call(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data) });
}

/// Lets the links to the parts of a run's page lead to a frame.
export function linkParts(frame) {
  history.replaceState(null, "", `#frame=${frame}`);
  for (const link of document.querySelectorAll("nav a")) link.hash = `frame=${frame}`;
}

/// A picture that cannot be shown takes nothing else with it.
export async function picture(path, lacking = "No picture") {
  const picture = new Image();
  picture.src = path;
  try {
    await picture.decode();
    return { picture, missing: "" };
  } catch {
    const missing = await call(path).catch((cause) => cause.message);
    return { picture: null, missing: `${lacking}: ${typeof missing === "string" ? missing : "it is damaged"}` };
  }
}

export class Frames {
  /// Of the run that the program tells of beneath `base`.
  constructor(run, base = "api") {
    this.run = run;
    this.base = base;
    this.kept = new Map();
    this.layers = [];
  }

  /// Which pictures are asked for beside those that each frame has: "road_surface", "classes".
  askFor(layers) {
    this.layers = layers;
    this.kept.clear();
  }

  get length() {
    return this.run.frames.length;
  }

  /// Record, shapes and picture of an index of the run.
  get(index) {
    const known = this.kept.get(index);
    this.kept.delete(index);
    const frame = known || this.load(index);
    this.kept.set(index, frame);
    if (this.kept.size > KEPT) this.kept.delete(this.kept.keys().next().value);
    // What failed may be tried again.
    frame.catch(() => this.kept.delete(index));
    return frame;
  }

  async load(index) {
    const { has_pictures, ground_area } = this.run;
    const nothing = { picture: null, missing: "No pictures: say where they are with --input." };
    const record = `${this.base}/records/${index}`;
    const layer = (name, lacking) =>
      this.layers.includes(name) ? picture(`${record}/${name}`, lacking) : { picture: null, missing: "" };
    const [said, shown, ground, surface, classes] = await Promise.all([
      call(record),
      has_pictures ? picture(`${record}/picture`) : nothing,
      ground_area ? picture(`${record}/ground_view`) : nothing,
      layer("road_surface"),
      layer("classes", "Nothing of what the network sees"),
    ]);
    const missing = shown.missing || classes.missing;
    return { ...said, picture: shown.picture, classes: classes.picture, missing, groundViews: [ground.picture, surface.picture].filter((one) => one) };
  }

  /// Asks for the neighbours, so that the next step finds them; the network is asked only about frames that are looked at.
  prepare(index) {
    if (this.layers.includes("classes")) return;
    for (const near of [index + 1, index - 1]) if (near >= 0 && near < this.length) this.get(near).catch(() => {});
  }

  /// The index of the frame with that number in the input, or of the next one that was used.
  indexOf(number) {
    const found = this.run.frames.findIndex((frame) => frame >= number);
    return found < 0 ? this.length - 1 : found;
  }

  /// The index of the frame that the address names.
  linked() {
    const number = Number(new URLSearchParams(location.hash.slice(1)).get("frame"));
    return this.indexOf(Number.isFinite(number) ? number : 0);
  }

  /// The index of the last frame that is no later than a time.
  indexAt(time_s) {
    const found = this.run.times_s.findIndex((t) => t > time_s);
    return found < 0 ? this.length - 1 : Math.max(0, found - 1);
  }
}
