// Questions to the operator.

import { byId, make } from './dom.js';

// Takes the answer to the question that is open; null where none is.
let answer = null;

/**
 * Asks a question and waits: true where it is answered with `yes`. `body` is elements or texts below the title. A question that was open
 * before is answered with no.
 */
export const ask = ({ title, body = [], yes, no = 'Cancel' }) => new Promise((answered) => {
  const dialog = byId('ask');
  answer?.(false);
  answer = answered;
  byId('ask-title').textContent = title;
  byId('ask-body').replaceChildren(...body.map((part) => (typeof part === 'string' ? make('p', {}, part) : part)));
  byId('ask-yes').textContent = yes;
  byId('ask-yes').hidden = yes === null;
  byId('ask-no').textContent = no;
  dialog.returnValue = 'no';
  // It stays open for the next question: that it was closed would be heard later, and taken for an answer to this one.
  if (!dialog.open) dialog.showModal();
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
  byId('ask').addEventListener('close', () => {
    if (byId('ask').open) return;
    answer?.(byId('ask').returnValue === 'yes');
    answer = null;
  });
  byId('ask-no').addEventListener('click', () => byId('ask').close('no'));
  byId('help-open').addEventListener('click', () => byId('help').showModal());
};
