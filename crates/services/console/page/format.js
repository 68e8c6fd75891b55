// Numbers, lengths and times for people.

// No minus before what rounds to 0.
export const centimetres = (metres) => `${(Math.round(metres * 1000) / 10 || 0).toFixed(1)} cm`;

export const percent = (share) => `${(share * 100).toFixed(1)} %`;

export const degrees = (radians) => `${Math.round((radians * 180) / Math.PI)}°`;

export const kilograms = (mass) => `${mass < 1 ? mass.toFixed(2) : mass.toFixed(1)} kg`;

export const milliseconds = (ms) => (ms >= 1000 ? `${(ms / 1000).toFixed(2)} s` : `${ms >= 10 ? ms.toFixed(0) : ms.toFixed(1)} ms`);

export const seconds = (s) => `${s >= 100 ? s.toFixed(0) : s.toFixed(1)} s`;

/** How long something takes or is ago, in ms, in whole units. */
export const span = (ms) => {
  const s = Math.max(0, Math.floor(ms / 1000));
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min`;
  return s < 86400 ? `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min` : `${Math.floor(s / 86400)} d`;
};

/** The time of day of a point in time, in Unix milliseconds. */
export const clock = (ms) => new Date(ms).toLocaleTimeString([], { hour12: false });

const MOST_OF_NAME = 60;

/** A name of the catalogue for people: tomato_soup_can is "tomato soup can"; one without end is cut. */
export const named = (object) => {
  const letters = [...object.replaceAll('_', ' ')];
  return letters.length > MOST_OF_NAME ? `${letters.slice(0, MOST_OF_NAME).join('')}…` : letters.join('');
};

export const items = (count) => (count === 1 ? '1 item' : `${count} items`);

/** A code such as all_packed, as words. */
export const words = (code) => code.replaceAll('_', ' ');
