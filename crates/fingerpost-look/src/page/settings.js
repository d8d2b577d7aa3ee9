// The settings as their schema declares them, each with what changes it.

import { element } from "./dom.js";

/// How far a slider goes from the value where it began, as a factor: declared ranges reach to what is possible at all.
const SLIDER_FACTOR = 3;

export const at = (values, key) => key.split(".").reduce((group, name) => group?.[name], values);
const shown = (value) => (value === null ? "none" : typeof value === "string" ? `"${value}"` : JSON.stringify(value));

/// What values a setting takes, in words.
function allowed({ minimum, maximum, oneOf, items }) {
  if (oneOf) return oneOf.map((choice) => choice.const).join(", ");
  const { minimum: least, maximum: most } = items ?? { minimum, maximum };
  return least === undefined || most === undefined ? "" : `${least} to ${most}`;
}

/// Names of items of the source are for its readers alone, and so are the marks about names.
const meaning = (text) => text.replaceAll(/ \(\[`\w+`\](; [^)]*)?\)/g, (_, rest) => (rest ? ` (${rest.slice(2)})` : "")).replaceAll("`", "");

/// One setting's inputs. `changed` is called with a new value; `show` puts one in.
function inputs(key, schema, value, changed) {
  if (schema.oneOf || schema.type === "boolean") {
    const choices = schema.oneOf?.map((choice) => choice.const) ?? [true, false];
    const select = element("select", { id: key }, ...choices.map((choice) => element("option", { value: String(choice), textContent: String(choice) })));
    select.addEventListener("change", () => changed(choices[select.selectedIndex]));
    return { all: [select], show: (value) => (select.selectedIndex = choices.indexOf(value)) };
  }
  if (schema.type !== "number" && schema.type !== "integer") {
    const field = element("input", { id: key, type: "text" });
    field.addEventListener("change", () => {
      try {
        changed(schema.type === "array" ? JSON.parse(`[${field.value}]`) : field.value || null);
      } catch {
        changed(field.value);
      }
    });
    return { all: [field], show: (value) => (field.value = Array.isArray(value) ? value.join(", ") : (value ?? "")) };
  }
  const whole = schema.type === "integer";
  const { minimum = -Infinity, maximum = Infinity } = schema;
  const near = value > 0 ? [Math.max(minimum, value / SLIDER_FACTOR), Math.min(maximum, value * SLIDER_FACTOR)] : [minimum, maximum];
  const [least, most] = whole ? [Math.ceil(near[0]), Math.floor(near[1])] : near;
  const number = element("input", { id: key, type: "number", step: "any" });
  const slider = element("input", { type: "range", min: least, max: most, step: whole ? 1 : (most - least) / 200 });
  slider.setAttribute("aria-label", `${key} by slider`);
  number.addEventListener("change", () => changed(number.valueAsNumber));
  // Numbers of a slider are as fine as its steps.
  slider.addEventListener("input", () => changed(whole ? Math.round(slider.valueAsNumber) : Number(slider.valueAsNumber.toPrecision(3))));
  return { all: Number.isFinite(most - least) ? [slider, number] : [number], show: (value) => (number.value = slider.value = value) };
}

export class Settings {
  /// `moved` is called with the key after each change.
  constructor(box, { schema, values }, moved) {
    this.values = values;
    this.changed = {};
    this.rows = new Map();
    this.moved = moved;
    this.tables = [];
    this.add(box, schema, []);
  }

  add(box, schema, path) {
    const fields = Object.entries(schema.properties);
    const own = fields.filter(([, inner]) => !inner.properties);
    if (own.length) {
      const table = element("details", { className: "settings" }, element("summary", { textContent: path.join(".") }));
      if (schema.description) table.append(element("p", { className: "hint", textContent: meaning(schema.description) }));
      for (const [name, inner] of own) table.append(this.row([...path, name].join("."), inner));
      box.append(table);
      this.tables.push(table);
    }
    for (const [name, inner] of fields) if (inner.properties) this.add(box, inner, [...path, name]);
  }

  row(key, schema) {
    const value = at(this.values, key);
    const { all, show } = inputs(key, schema, value, (value) => this.set(key, value));
    show(value);
    const unit = schema["x-unit"] ?? schema.items?.["x-unit"] ?? "";
    const label = element("label", { htmlFor: key, textContent: key });
    const reset = element("button", { textContent: "Reset", hidden: true });
    reset.setAttribute("aria-label", `Reset ${key}`);
    reset.addEventListener("click", () => this.reset(key));
    const facts = [unit, allowed(schema), `default ${shown(schema.default)}`].filter(Boolean).join(" · ");
    const words = element("p", { className: "hint", id: `${key}-hint`, textContent: `${meaning(schema.description)} ${facts}` });
    const error = element("p", { className: "refused", role: "alert" });
    for (const input of all) input.setAttribute("aria-describedby", words.id);
    const row = element("div", { className: "setting" }, label, reset, element("div", { className: "inputs" }, ...all), error, words);
    this.rows.set(key, { row, show, reset, error, text: `${key} ${words.textContent}`.toLowerCase() });
    return row;
  }

  /// Sets a value; that of the run is no change.
  set(key, value) {
    if (typeof value === "number" && Number.isNaN(value)) return;
    const { row, show, reset } = this.rows.get(key);
    const isChanged = JSON.stringify(value) !== JSON.stringify(at(this.values, key));
    if (isChanged) this.changed[key] = value;
    else delete this.changed[key];
    show(value);
    row.classList.toggle("changed", isChanged);
    reset.hidden = !isChanged;
    this.moved(key);
  }

  reset(key) {
    this.set(key, at(this.values, key));
  }

  /// Takes over many at once, in place of all that were changed.
  replace(changed) {
    for (const key of Object.keys(this.changed)) if (!(key in changed)) this.reset(key);
    for (const [key, value] of Object.entries(changed)) if (this.rows.has(key)) this.set(key, value);
  }

  /// Says at a setting why it is refused; nothing of all others.
  refuse(key, text) {
    for (const [of, { error, row }] of this.rows) {
      error.textContent = of === key ? text : "";
      if (of === key) row.closest("details").open = true;
    }
    return this.rows.has(key);
  }

  /// Shows those whose key or meaning has the words, opened; without words all, closed but for tables with changes.
  search(words) {
    for (const { row, text } of this.rows.values()) row.hidden = !text.includes(words.toLowerCase());
    for (const table of this.tables) {
      const rows = [...table.querySelectorAll(".setting")];
      table.hidden = rows.every((row) => row.hidden);
      table.open = words ? true : rows.some((row) => row.classList.contains("changed"));
    }
  }
}
