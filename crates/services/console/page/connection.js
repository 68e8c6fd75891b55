// The stream of events: kept open, watched, and opened anew by itself.

const SILENCE_MS = 3000;
const OPENING_MS = 6000;
const LOOK_MS = 250;
const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 4000;

/**
 * Follows `url`. `heard(kind, data)` gets each event; `changed()` is called where `contact` changed. Contact is `connecting` before the
 * first event, `live`, or `lost` after three seconds of silence or the end of the stream.
 */
export class Connection {
  constructor(url, heard, changed) {
    Object.assign(this, { url, heard, changed, contact: 'connecting', source: null, wait: FIRST_WAIT_MS, timer: null });
    this.last = performance.now();
    this.open();
    setInterval(() => this.look(), LOOK_MS);
    // A tablet that was asleep looks at once.
    document.addEventListener('visibilitychange', () => document.hidden || this.look());
    window.addEventListener('online', () => this.contact === 'live' || this.again(0));
  }

  /** For how long nothing was heard, in ms. */
  silence() {
    return performance.now() - this.last;
  }

  open() {
    clearTimeout(this.timer);
    this.timer = null;
    this.opened = performance.now();
    const source = new EventSource(this.url);
    this.source = source;
    for (const kind of ['snapshot', 'part', 'beat']) {
      source.addEventListener(kind, (event) => this.source === source && this.take(kind, event.data));
    }
    source.addEventListener('error', () => this.source === source && this.lose());
  }

  take(kind, text) {
    this.last = performance.now();
    this.wait = FIRST_WAIT_MS;
    this.heard(kind, JSON.parse(text), this.last);
    if (kind === 'snapshot') this.become('live');
  }

  look() {
    const isSilent = this.contact === 'live' ? this.silence() > SILENCE_MS : performance.now() - this.opened > OPENING_MS;
    if (this.source && isSilent) this.lose();
  }

  lose() {
    this.become('lost');
    this.again(this.wait);
    this.wait = Math.min(2 * this.wait, LONGEST_WAIT_MS);
  }

  again(wait) {
    this.source?.close();
    this.source = null;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.open(), wait);
  }

  become(contact) {
    if (this.contact === contact) return;
    this.contact = contact;
    this.changed();
  }
}
