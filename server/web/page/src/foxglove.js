// The address by which another viewer may look on at the scene: the server gives a ticket for each.

import {say} from './language.js';
import {socketAddress} from './socket.js';

export class Foxglove {
  /** @param {HTMLDialogElement} dialog what shows an address */
  constructor(dialog) {
    this.dialog = dialog;
    this.address = dialog.querySelector('input');
    this.address.onfocus = () => this.address.select();
    const copy = dialog.querySelector('button[type=button]');
    copy.onclick = async () => {
      this.address.select();
      try {
        await navigator.clipboard.writeText(this.address.value);
        copy.textContent = say('foxglove.copied');
      } catch {
        copy.textContent = say('foxglove.press');  // The browser lets this page write no clipboard.
      }
    };
    dialog.addEventListener('close', () => {
      this.address.blur();  // The browser would do it with the next frame; a key that comes before is for the page.
      this.address.value = '';
      copy.textContent = say('foxglove.copy');
    });
  }

  /** @param {{path: string, seconds: number}} ticket what the server said */
  show(ticket) {
    this.address.value = socketAddress(`.${ticket.path}`);
    this.dialog.querySelector('p').textContent = say('foxglove.how', {seconds: ticket.seconds});
    if (!this.dialog.open) this.dialog.showModal();
  }
}
