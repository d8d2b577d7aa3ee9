// A record as tables: one for what stands alone, one a group.

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
  const made = document.createElement("td");
  if (isShort(value)) {
    made.textContent = text(value);
    return made;
  }
  const list = document.createElement("details");
  list.open = opened.has(name);
  list.addEventListener("toggle", () => opened[list.open ? "add" : "delete"](name));
  const head = document.createElement("summary");
  head.textContent = `${value.length} entries`;
  const items = value.map((item) => (isGroup(item) ? rows(item).map(([key, of]) => `${key} ${text(of)}`).join(", ") : text(item)));
  list.append(head, items.join(" · "));
  made.append(list);
  return made;
}

function table(name, entries, opened) {
  const made = document.createElement("table");
  const caption = made.createCaption();
  caption.textContent = name;
  for (const [key, value] of entries) {
    const row = made.insertRow();
    const head = Object.assign(document.createElement("th"), { scope: "row", textContent: key });
    row.append(head, cell(value, `${name}.${key}`, opened));
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
