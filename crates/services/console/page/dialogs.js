// Questions to the operator.

import { byId, make } from './dom.js';

/**
 * Asks a question and waits: true where it is answered with `yes`. `body` is elements or texts below the title. A question that was open
 * before is answered with no.
 */
export const ask = ({ title, body = [], yes, no = 'Cancel' }) => new Promise((answered) => {
  const dialog = byId('ask');
  if (dialog.open) dialog.close('no');
  byId('ask-title').textContent = title;
  byId('ask-body').replaceChildren(...body.map((part) => (typeof part === 'string' ? make('p', {}, part) : part)));
  byId('ask-yes').textContent = yes;
  byId('ask-yes').hidden = yes === null;
  byId('ask-no').textContent = no;
  dialog.returnValue = 'no';
  dialog.addEventListener('close', () => answered(dialog.returnValue === 'yes'), { once: true });
  dialog.showModal();
  // What moves a robot is not what Enter does by itself.
  (dialog.querySelector('#ask-body input') ?? byId('ask-no')).focus();
});

/** Tells something, until it is read. */
export const tell = (title, ...body) => ask({ title, body, yes: null, no: 'Close' });

/** Readies the dialogs of the page. */
export const readyDialogs = () => {
  for (const dialog of [byId('ask'), byId('help')]) {
    dialog.addEventListener('click', (event) => event.target === dialog && dialog.close('no'));
  }
  byId('ask-no').addEventListener('click', () => byId('ask').close('no'));
  byId('help-open').addEventListener('click', () => byId('help').showModal());
};
