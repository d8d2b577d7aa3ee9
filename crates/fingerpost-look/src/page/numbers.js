// A record as tables: one for what stands alone, one a group.

import { element } from "./dom.js";

/// Longest list that is written out in its cell.
const SHORT = 6;

const isGroup = (value) => value !== null && typeof value === "object" && !Array.isArray(value);
const isShort = (value) => !Array.isArray(value) || (value.length <= SHORT && value.every((item) => typeof item !== "object"));
const text = (value) => (value === null ? "–" : Array.isArray(value) ? value.map(text).join(", ") : String(value));

/// What a group holds, with those of groups in it, as names and values.
function rows(group, before = "") {
  return Object.entries(group).flatMap(([key, value]) =>
    isGroup(value) ? rows(value, `${before}${key}.`) : [[before + key, value]],
  );
}

function cell(value, name, opened) {
  if (isShort(value)) return element("td", {}, text(value));
  const items = value.map((item) => (isGroup(item) ? rows(item).map(([key, of]) => `${key} ${text(of)}`).join(", ") : text(item)));
  const head = element("summary", {}, `${value.length} entries`);
  const list = element("details", { open: opened.has(name) }, head, items.join(" · "));
  list.addEventListener("toggle", () => opened[list.open ? "add" : "delete"](name));
  return element("td", {}, list);
}

function table(name, entries, opened) {
  const made = element("table", {}, element("caption", {}, name));
  for (const [key, value] of entries) {
    const row = made.insertRow();
    row.append(element("th", { scope: "row" }, key), cell(value, `${name}.${key}`, opened));
    row.dataset.name = `${name}.${key}`;
  }
  return made;
}

/// Shows a record; `opened` remembers which long lists are open.
export function showNumbers(box, name, record, opened) {
  const entries = Object.entries(record);
  const alone = entries.filter(([, value]) => !isGroup(value));
  const groups = entries.filter(([, value]) => isGroup(value) && Object.keys(value).length);
  box.replaceChildren(
    table(name, alone, opened),
    ...groups.map(([group, value]) => table(group, rows(value), opened)),
  );
}
