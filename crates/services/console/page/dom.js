// Making elements. Text is always text: what comes from a cell is never read as markup.

const SVG = 'http://www.w3.org/2000/svg';

const filled = (made, attributes, children) => {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === 'onclick') made.addEventListener('click', value);
    else made.setAttribute(name, value === true ? '' : String(value));
  }
  made.append(...children.filter((child) => child !== null && child !== undefined && child !== false));
  return made;
};

/** An element with these attributes and children; a child is an element or a text, and one that is null is left out. */
export const make = (tag, attributes = {}, ...children) => filled(document.createElement(tag), attributes, children);

export const svg = (tag, attributes = {}, ...children) => filled(document.createElementNS(SVG, tag), attributes, children);

export const byId = (id) => document.getElementById(id);

/** Sets a text where it is another one: what is the same is not announced again. */
export const setText = (element, text) => {
  if (element.textContent !== text) element.textContent = text;
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
