// What this browser remembers: dark or light, and whether letters act.

import { byId, setText } from './dom.js';

const THEMES = { automatic: 'Theme: automatic', dark: 'Theme: dark', light: 'Theme: light' };

/** What is kept in a storage, which `open` gives. A browser may forbid that: then nothing is kept once the page is left. */
export const memory = (open) => ({
  kept(name) {
    try {
      return open().getItem(name);
    } catch {
      return null;
    }
  },
  keep(name, value) {
    try {
      if (value === null) open().removeItem(name);
      else open().setItem(name, value);
    } catch {
      // It holds until the page is left.
    }
  },
});

const { kept, keep } = memory(() => localStorage);

const apply = (theme) => {
  if (theme === 'automatic') delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  document.documentElement.dataset.chosenTheme = theme;
  setText(byId('theme'), THEMES[theme]);
};

/** Readies the choice of the theme. */
export const readyTheme = () => {
  const names = Object.keys(THEMES);
  const before = kept('ppnpack-theme');
  apply(names.includes(before) ? before : 'automatic');
  byId('theme').addEventListener('click', () => {
    const next = names[(names.indexOf(document.documentElement.dataset.chosenTheme) + 1) % names.length];
    apply(next);
    keep('ppnpack-theme', next);
  });
};

/** Has letters do what `acts` says: a function for each. They do nothing while a text is written, or where they are switched off. */
export const readyKeys = (acts) => {
  const isOn = byId('keys-on');
  isOn.checked = kept('ppnpack-keys') !== 'off';
  isOn.addEventListener('change', () => keep('ppnpack-keys', isOn.checked ? 'on' : 'off'));
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat || !isOn.checked) return;
    if (event.target.closest('input:not([type=checkbox]), select, textarea')) return;
    const act = acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
};
