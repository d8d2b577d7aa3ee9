// Parts of the page, found and made.

export const $ = (id) => document.getElementById(id);

/// An element with these properties and children.
export function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

/// The same of an SVG, whose attributes are texts.
export function svgElement(name, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/// A name that breaks behind its dots and underscores, where its place is narrow.
export const breakable = (name) => name.split(/(?<=[._])(?=[a-z])/).flatMap((part) => [part, element("wbr")]);
