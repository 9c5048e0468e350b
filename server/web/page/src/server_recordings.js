// The recordings that the server makes of the scene: an admin starts and stops them, saves them, and opens them in the page's replay.

import {make} from './elements.js';
import {say} from './language.js';

const size = (bytes) => (bytes / 1e6).toFixed(1);

export class ServerRecordings {
  /** @param {(message: object) => void} send to the server @param {(file: File) => void} open shows a recording */
  constructor(send, open) {
    this.send = send;
    this.open = open;
    this.wanted = null;  // what is done with the recording whose ticket was asked for
    this.toggle = make('button', {id: 'server-record', onclick: () => send({recording: this.running ? 'stop' : 'start'})});
    this.state = make('p', {id: 'server-record-state'});
    this.list = make('ul', {className: 'recordings'});
    this.element = make('div', {hidden: true}, make('h3', {}, say('admin.recordings')), this.toggle, this.state, this.list);
    this.forget();
  }

  /** Another scene is watched, or the viewer is no admin. */
  forget() {
    this.wanted = null;
    this.#show({running: null, seconds: 0, bytes: 0, ended: 'none', kept: []});
  }

  /** The server has refused what was asked for. */
  refuse() {
    this.wanted = null;
  }

  /** @param {object} message of the server: recordings, or download */
  take(message) {
    if (message.type === 'recordings') this.#show(message);
    else this.#fetch(message);
  }

  #show({running, seconds, bytes, ended, kept}) {
    this.running = running !== null;
    this.toggle.textContent = say(this.running ? 'admin.recording.stop' : 'admin.recording.start');
    this.toggle.ariaPressed = String(this.running);
    if (this.running) this.state.textContent = say('admin.recording.runs', {seconds, size: size(bytes)});
    else if (['size', 'time', 'room', 'failed'].includes(ended)) this.state.textContent = say(`admin.recording.ended.${ended}`, {seconds, size: size(bytes)});
    else this.state.textContent = '';
    this.state.hidden = this.state.textContent === '';
    const known = new Map([...this.list.children].map((row) => [row.dataset.name, row]));
    const rows = kept.map((file) => known.get(file.name) ?? this.#makeRow(file));
    if (rows.length !== known.size || rows.some((row, i) => row !== this.list.children[i])) this.list.replaceChildren(...rows);
  }

  #makeRow({name, bytes}) {
    const button = (what) => make('button', {title: say(`record.${what}.hint`), ariaLabel: `${say(`record.${what}`)} ${name}`, onclick: () => this.#want(what, name)}, say(`record.${what}`));
    const row = make('li', {}, make('span', {}, name, make('i', {}, ` ${size(bytes)} MB`)), button('save'), button('open'));
    row.dataset.name = name;
    return row;
  }

  #want(what, name) {
    this.wanted = {what, name};
    this.send({download: name});
  }

  /** A ticket lets this browser fetch the recording once. */
  async #fetch({name, path}) {
    if (this.wanted?.name !== name) return;
    const {what} = this.wanted;
    this.wanted = null;
    if (what === 'save') {
      make('a', {href: `.${path}`, download: name}).click();
      return;
    }
    this.state.hidden = false;
    this.state.textContent = say('admin.recording.loads', {name});
    try {
      const answer = await fetch(`.${path}`);
      if (!answer.ok) throw new Error(answer.statusText);
      this.open(new File([await answer.blob()], name));
    } catch (error) {
      this.state.textContent = say('admin.recording.lost', {name, why: error.message});
    }
  }
}
