// Records beside one another: the same number of each in a row, marked where two differ.

import { breakable, element } from "./dom.js";

const isGroup = (value) => value !== null && typeof value === "object" && !Array.isArray(value);

/// All numbers and texts of a record by their names, a group's with its name before.
export function leaves(group, before = "") {
  return Object.entries(group).flatMap(([key, value]) => {
    const name = before + key;
    if (isGroup(value)) return leaves(value, `${name}.`);
    // What has an identity is held against its like, wherever it stands in its list.
    if (Array.isArray(value) && value.length && value.every((item) => isGroup(item) && "id" in item)) {
      return value.flatMap((item) => leaves(item, `${name} ${item.id}.`));
    }
    return [[name, value]];
  });
}

function text(value) {
  if (value === null || value === undefined) return "–";
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(5)));
  return Array.isArray(value) ? value.map((item) => (isGroup(item) ? leaves(item).map(([, of]) => text(of)).join(" ") : text(item))).join(", ") : String(value);
}

/// A table of records, which may be null, under their names; `marked` are the two columns that are held against each other.
export function columns(names, records, keys, marked) {
  const table = element("table", { className: "columns" });
  const head = table.createTHead().insertRow();
  for (const name of ["", ...names]) head.append(element("th", { scope: "col" }, name));
  const known = records.map((record) => new Map(record ? leaves(record) : []));
  const body = table.createTBody();
  for (const key of keys) {
    const values = known.map((record) => text(record.get(key)));
    if (values.every((value) => value === "–")) continue;
    const row = body.insertRow();
    row.dataset.name = key;
    row.append(element("th", { scope: "row" }, ...breakable(key)));
    for (const value of values) row.append(element("td", {}, ...breakable(value)));
    const [one, other] = marked;
    if (records[one] && records[other] && values[one] !== values[other]) row.className = "differs";
  }
  return table;
}

/// Why each record decided so, under its name; the same words once.
export function reasons(names, records) {
  const by = Map.groupBy(names.filter((_, index) => records[index]), (name) => records[names.indexOf(name)].why);
  return [...by].map(([why, names]) => element("p", {}, element("b", {}, `${names.join(", ")}: `), why));
}

/// The names of what differs between two records, times of stages aside, and not among `known`.
export function differing(one, other, known) {
  if (!one || !other) return [];
  const [first, second] = [one, other].map((record) => new Map(leaves(record)));
  const keys = [...new Set([...first.keys(), ...second.keys()])];
  const isNews = (key) => key !== "why" && !key.startsWith("stage_ms.") && !known.includes(key);
  return keys.filter((key) => isNews(key) && JSON.stringify(first.get(key)) !== JSON.stringify(second.get(key)));
}

/// The numbers that say what came of a frame, in the order of the method.
export const KEY_NUMBERS = [
  "state", "feature.id", "feature.kind", "feature.forward_m", "feature.left_m", "feature.sigma_m", "feature.present", "feature.p",
  "sought.id", "sought.forward_m", "sought.present", "sought.p", "route_m", "motion.forward_m", "centreline.offset_m", "lanes.width_m",
  "advice.line", "advice.steer_rad", "advice.speed_mps", "advice.stop",
];
