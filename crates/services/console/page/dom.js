// Making elements. Text is always text: what comes from a cell is never read as markup.

const SVG = 'http://www.w3.org/2000/svg';

// What turns the direction of writing would let one text change how the next one reads.
const turning = /[\u0000-\u0008\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;

/** A text without characters that are not seen and change how others are. */
export const plain = (text) => text.replaceAll(turning, '');

const filled = (made, attributes, children) => {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === 'onclick') made.addEventListener('click', value);
    else made.setAttribute(name, value === true ? '' : plain(String(value)));
  }
  const given = children.filter((child) => child !== null && child !== undefined && child !== false);
  made.append(...given.map((child) => (typeof child === 'string' ? plain(child) : child)));
  return made;
};

/** An element with these attributes and children; a child is an element or a text, and one that is null is left out. */
export const make = (tag, attributes = {}, ...children) => filled(document.createElement(tag), attributes, children);

export const svg = (tag, attributes = {}, ...children) => filled(document.createElementNS(SVG, tag), attributes, children);

/** A table: of each column its name, and a class or null; then the rows. */
export const table = (columns, rows, attributes = {}) => {
  const heads = columns.map(([name, kind]) => make('th', { scope: 'col', class: kind }, name));
  return make('table', attributes, make('thead', {}, make('tr', {}, ...heads)), make('tbody', {}, ...rows));
};

export const byId = (id) => document.getElementById(id);

/** Sets a text where it is another one: what is the same is not announced again. */
export const setText = (element, text) => {
  const shown = plain(text);
  if (element.textContent !== shown) element.textContent = shown;
};

/**
 * Replaces the children of an element by what `build` makes of `data`, unless that is as it was the last time. What had the focus, and
 * is there again with the same data-key, has it again.
 */
export const redraw = (element, data, build) => {
  const said = JSON.stringify(data);
  if (drawn.get(element) === said) return;
  drawn.set(element, said);
  const key = element.contains(document.activeElement) ? document.activeElement.dataset.key : undefined;
  element.replaceChildren(...[build(data)].flat().filter(Boolean));
  if (key === undefined) return;
  [...element.querySelectorAll('[data-key]')].find((one) => one.dataset.key === key)?.focus({ preventScroll: true });
};
const drawn = new WeakMap();
