// The controls: asked of the console with the token, and each that moves the robot asked again.

import { ordered, swatch, where } from './contents.js';
import { ask } from './dialogs.js';
import { byId, make, setText } from './dom.js';
import { items as counted, milliseconds, named } from './format.js';
import { memory } from './preferences.js';

const TOKEN = 'ppnpack-console-token';
// A new container is answered after half a minute at the latest, everything else much sooner.
const PATIENCE_MS = { new_container: 45000, hold: 7000, abort: 7000 };
const USUAL_PATIENCE_MS = 15000;

// What a token is made of, and a header takes.
const VISIBLE = /^[\x21-\x7e]+$/;

const NO_ANSWER = 'the console does not answer. Look at the cell; to stop the robot, use the cell\'s own stop.';

const { kept, keep } = memory(() => sessionStorage);

const STOPS = ['hold', 'abort'];

const NAMES = {
  hold: 'Hold', abort: 'Abort', resume: 'Resume', step: 'Step', touched: 'I had my hand in it', removed: 'Item removed',
  withdraw: 'Withdraw', new_container: 'New container', automatic: 'Go on',
};

export class Controls {
  /** `where()` says which cell and container are shown, what lies there, and which item was tapped: `{ cell, container, items, picked }`. */
  constructor(where) {
    this.where = where;
    this.token = kept(TOKEN);
    // When a hold was asked for, while the cell does not show it.
    this.asked = null;
    this.isHeld = false;
    // What is shown: the console is told it, so that nothing ends that was not seen.
    this.seen = { hold_ids: [], failure_id: '' };
    for (const button of document.querySelectorAll('[data-act]')) {
      button.addEventListener('click', () => this.act(button.dataset.act));
    }
    byId('unlock').addEventListener('click', () => (this.token ? this.lock() : this.unlock()));
  }

  /** Shows which controls there are. `status` is that of the cell, or null. */
  show(console_, status) {
    const isOff = !console_?.controls;
    this.isOff = isOff;
    const isHeld = (status?.held ?? null) !== null;
    this.isHeld = isHeld;
    this.seen = { hold_ids: status?.holds ?? [], failure_id: status?.failure_id ?? '' };
    const needs = { resume: isHeld, step: isHeld, automatic: status?.doing === 'failed' };
    for (const button of document.querySelectorAll('[data-act]')) {
      const { act } = button.dataset;
      button.disabled = isOff || !(needs[act] ?? true);
    }
    byId('go-on').hidden = !needs.automatic;
    byId('resume').hidden = needs.automatic && !isHeld;
    byId('unlock').hidden = isOff;
    setText(byId('unlock'), this.token ? 'Lock controls' : 'Unlock controls');
    byId('off').hidden = !isOff || !console_;
    setText(byId('off'), console_?.why_off ? `Watching only. Controls are off: ${console_.why_off}` : 'Watching only. Controls are off.');
    if (isHeld && this.asked !== null) {
      this.reply('going', `Held ${milliseconds(performance.now() - this.asked)} after it was asked for.`);
      this.asked = null;
    }
  }

  /** What a button or a letter does. */
  act(name) {
    if (this.isOff || byId('acts').querySelector(`[data-act=${name}]`)?.disabled) return;
    const { hold_ids, failure_id } = this.seen;
    const acts = {
      resume: () => this.send('resume', { hold_ids }),
      step: () => this.send('step', { hold_ids }),
      removed: () => this.askRemoved(this.where().picked),
      touched: () => this.askTouched(),
      automatic: () => this.send('automatic', { is_on: true, failure_id }),
    };
    (acts[name] ?? (() => this.send(name)))();
  }

  async askTouched() {
    const at = this.where();
    const yes = await ask({
      title: 'A hand was in the container',
      body: [
        `${at.container}: it is seen anew, and what was planned before is not carried out.`,
        'Items that were taken out are named with “Item removed”.',
      ],
      yes: 'Yes, see it anew',
    });
    if (yes) this.send('touched', { container: at.container }, at);
  }

  /** Asks which items were taken out; one may be chosen before. */
  async askRemoved(itemId) {
    const at = this.where();
    const { container, items } = at;
    if (items.length === 0) {
      this.reply('held', 'Nothing is known to lie in the container.');
      return;
    }
    const choices = ordered(items).map((item) => {
      const box = make('input', { type: 'checkbox', value: item.item_id });
      box.checked = item.item_id === itemId;
      const told = [make('span', {}, `${named(item.object)} (${item.item_id})`), make('span', { class: 'soft small' }, where(item))];
      return make('li', {}, make('label', {}, box, swatch(item.item_id), ...told));
    });
    const list = make('ul', { class: 'choices' }, ...choices);
    const yes = await ask({
      title: 'Which items were taken out?', body: [`Of ${counted(items.length)} in ${container}, the last one first. It is seen anew.`, list], yes: 'These were taken out',
    });
    const chosen = [...list.querySelectorAll('input')].filter((box) => box.checked).map((box) => box.value);
    if (yes && chosen.length === 0) this.reply('held', 'No item was chosen: nothing was changed.');
    else if (yes) this.send('removed', { container, item_ids: chosen }, at);
  }

  async withdraw(item) {
    const at = this.where();
    const told = `${named(item.object)} (${item.item_id}) is not packed.`;
    const yes = await ask({ title: 'This item does not come', body: [told], yes: 'It does not come' });
    if (yes) this.send('withdraw', { item_ids: [item.item_id] }, at);
  }

  /** Asks for the token; whether it is right. */
  async unlock(why = '') {
    const input = make('input', { type: 'password', id: 'token', autocomplete: 'off', spellcheck: 'false', 'aria-describedby': 'token-why' });
    const label = make('label', { for: 'token' }, 'Token of this console');
    const said = make('p', { id: 'token-why', role: why ? 'alert' : null }, why || 'It is kept until this tab is closed.');
    const yes = await ask({ title: 'Unlock controls', body: [label, input, said], yes: 'Unlock' });
    if (!yes) return false;
    const token = input.value.trim();
    if (!VISIBLE.test(token)) return this.unlock('That is not the token.');
    const { status, text } = await this.post('check', {}, token);
    if (status === 401) return this.unlock('That is not the token.');
    if (status !== 200) {
      this.reply('stopped', text);
      return false;
    }
    this.remember(token);
    this.reply('going', 'Controls are unlocked in this tab.');
    return true;
  }

  lock() {
    this.remember(null);
    this.reply('idle', 'Controls are locked.');
  }

  remember(token) {
    this.token = token;
    keep(TOKEN, token);
    setText(byId('unlock'), this.token ? 'Lock controls' : 'Unlock controls');
  }

  /** Sends a control, with the token, of the cell and container that are shown now, or were when it was asked about. */
  async send(action, fields = {}, at = this.where()) {
    if (!this.token && !(await this.unlock())) return;
    const body = { cell: at.cell, ...(action === 'new_container' ? { container: at.container } : {}), ...fields };
    this.asked = STOPS.includes(action) && !this.isHeld ? performance.now() : null;
    this.reply('idle', `${NAMES[action]}: asked for…`);
    const answer = await this.post(action, body, this.token);
    await this.understand(action, fields, at, answer);
  }

  async understand(action, fields, at, { status, error, question, text }) {
    if (status === 409 && error === 'unconfirmed') {
      this.reply('idle', '');
      const what = action === 'new_container' ? at.container : at.cell;
      const yes = await ask({ title: `${NAMES[action]}: ${what}`, body: [question ?? text], yes: NAMES[action] });
      if (yes) await this.send(action, { ...fields, confirmed: true }, at);
    } else if (status === 401) {
      this.remember(null);
      this.reply('stopped', 'Refused: that is not the token.');
      if (await this.unlock('That is not the token any more.')) await this.send(action, fields, at);
    } else if (status === 200) {
      // Of a stop it is said besides when the cell shows it.
      this.reply('going', text);
    } else {
      this.asked = null;
      // Without an answer of the console, or of whom it asked, nobody knows what was done.
      const isRefused = status >= 400 && status < 500;
      this.reply('stopped', `${NAMES[action]} ${isRefused ? 'was refused' : 'may have been done, or not'}: ${text}`);
    }
  }

  /** The answer of the console: its status and what it says. 0 where none came. */
  async post(action, body, token) {
    try {
      const answer = await fetch(`api/control/${action}`, {
        method: 'POST',
        headers: { 'Content-Type': 'application/json', Authorization: `Bearer ${token}` },
        body: JSON.stringify(body),
        signal: AbortSignal.timeout(PATIENCE_MS[action] ?? USUAL_PATIENCE_MS),
      });
      return { text: `it answered ${answer.status}`, ...(await answer.json()), status: answer.status };
    } catch {
      return { status: 0, text: NO_ANSWER };
    }
  }

  /** Says what became of a control. */
  reply(level, text) {
    const line = byId('reply');
    line.dataset.level = level;
    line.hidden = text === '';
    setText(line, text);
  }
}
