// The button that records, and the line that offers what was recorded.

import {say} from './language.js';
import {fileName, save} from './save.js';
import {SceneRecorder} from './scene_recorder.js';

const PERIOD = 200;  // [ms] between two writings of the time
const element = (id) => document.getElementById(id);

export class RecordBar {
  /**
   * @param {() => {version: string}} page of the server @param {(message: object) => void} send to the server
   * @param {(file: File) => void} open shows a recording
   */
  constructor(page, send, open) {
    this.page = page;
    this.send = send;
    this.recorder = null;
    this.asked = false;  // whether a ticket was asked for
    this.scene = null;  // the server's message of the scene that is watched
    this.file = null;  // what was recorded
    this.saved = true;
    element('record').onclick = () => this.toggle();
    element('recorded-save').onclick = () => {
      save(this.file, this.file.name);
      this.saved = true;
    };
    element('recorded-open').onclick = () => open(this.file);
    element('recorded-drop').onclick = () => this.#forget();
    addEventListener('beforeunload', (event) => {
      if (!this.saved || this.recorder) event.preventDefault();
    });
    setInterval(() => this.recorder && this.#write(), PERIOD);
  }

  /** Keys of the page that act here. */
  bindings() {
    return [{keys: ['r'], text: say('keys.record'), act: () => this.toggle()}];
  }

  toggle() {
    if (this.recorder) return this.#stop('');
    if (this.asked || !this.scene) return undefined;
    this.asked = true;
    return this.send({ticket: this.scene.name});
  }

  /** Another scene is watched, or it was loaded again. @param {object} scene the server's message */
  watch(scene) {
    this.end(say('record.why.scene'));
    this.scene = scene;
  }

  /** @param {{scene: string, path: string}} ticket of the server @returns {boolean} whether it was asked for here */
  takeTicket(ticket) {
    if (!this.asked) return false;
    this.asked = false;
    this.#forget();
    this.recorder = new SceneRecorder(ticket.path, this.scene, this.page().version, (why) => this.#stop(why));
    this.#write();
    return true;
  }

  /** The server gives no ticket. */
  refuse() {
    this.asked = false;
  }

  /** The connection was lost, or another scene is watched. @param {string} why */
  end(why) {
    this.asked = false;
    if (this.recorder) this.#stop(why);
  }

  /** For tests. */
  get seconds() {
    return this.recorder?.seconds ?? null;
  }

  /** @param {string} why it ended by itself; empty: the user ended it */
  #stop(why) {
    const {seconds, name} = this.recorder;
    const parts = this.recorder.stop();
    this.recorder = null;
    this.#write();
    this.file = parts && new File(parts, fileName('mcap', name), {type: 'application/octet-stream'});
    this.saved = this.file === null;
    const ended = why && say('record.ended', {why});
    const said = this.file ? say('record.done', {seconds: seconds.toFixed(1), name, size: (this.file.size / 1e6).toFixed(1)}) : say('record.nothing');
    element('recorded').hidden = false;
    element('recorded').querySelector('span').textContent = said + ended;
    for (const id of ['recorded-save', 'recorded-open']) element(id).hidden = !this.file;
  }

  #forget() {
    this.file = null;
    this.saved = true;
    element('recorded').hidden = true;
  }

  #write() {
    const button = element('record');
    const text = this.recorder ? say('head.record.stop', {seconds: Math.floor(this.recorder.seconds)}) : say('head.record');
    if (button.textContent !== text) button.textContent = text;
    button.setAttribute('aria-pressed', String(this.recorder !== null));
  }
}
