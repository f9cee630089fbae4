// Colours, from the style sheet: they follow the light or dark scheme, and paper is light.

let cache = new Map();
const listeners = [];

/** A custom property of the root, "--ink". */
export function colour(name) {
  if (!cache.has(name)) cache.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return cache.get(name);
}

export const PALETTE_SIZE = 8;
export function paletteColour(index) {
  return colour(`--c${((index % PALETTE_SIZE) + PALETTE_SIZE) % PALETTE_SIZE}`);
}

/** Calls `listener({printing})` when colours or the medium have changed. */
export function onTheme(listener) {
  listeners.push(listener);
}

function changed(printing) {
  cache = new Map();
  for (const listener of listeners) listener({ printing });
}

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => changed(false));
addEventListener('beforeprint', () => {
  document.documentElement.classList.add('printing');
  changed(true);
});
addEventListener('afterprint', () => {
  document.documentElement.classList.remove('printing');
  changed(false);
});
