// The admin's panel: knobs for materials, gravity and the chosen session. Everyone sees their values; an admin turns them. The server
// judges every value; what it refuses is said here.

import {make, makeTabs} from './elements.js';
import {say} from './language.js';
import {ServerRecordings} from './server_recordings.js';

const PERIOD = 150;  // [ms] between two messages of a knob that is dragged
const PER_DECADE = 100;  // steps of the stiffness slider

/** Fields of a material: name in messages, unit, step of the arrows. */
const FIELDS = [
  ['stiffness', 'N/m', 'any'], ['damping', 'N s/m', '0.1'], ['static_friction', '', '0.05'], ['dynamic_friction', '', '0.05'], ['viscous_friction', 'N s/m', '0.1'],
];

/** Of an emulated link: name in messages, unit, how many of the unit are one of the message. */
const LINK = [['link_delay', 'ms', 1e3], ['link_jitter', 'ms', 1e3], ['link_loss', '%', 100]];

/** Numbers of a bound: name in messages and of a session, unit. The server judges them, and fills what is not given. */
const BOUND = [
  ['velocity_cutoff', 'Hz'],  // First: it is the server's, whoever bounds.
  ['operator_damping', 'N s/m'], ['c1', 'N/m'], ['c2', 'N/m'], ['coupling_stiffness', 'N/m'], ['coupling_damping', 'N s/m'], ['tool_mass', 'kg'],
];

/** A row with a number, kept in `inputs` by its field. @param {Map<string, HTMLInputElement>} inputs */
function numberRow(inputs, [field, unit], properties) {
  const input = make('input', {type: 'number', step: 'any', min: 0, ...properties});
  inputs.set(field, input);
  return make('label', {}, make('span', {}, say(`admin.${field}`)), input, make('i', {}, unit));
}

/** Puts a value into an input that nobody is using. */
function fill(input, value) {
  if (document.activeElement !== input) input.value = value;
}

export class Admin {
  /** @param {HTMLElement} panel @param {(message: object) => void} send @param {(file: File) => void} open shows a recording */
  constructor(panel, send, open) {
    this.panel = panel;
    this.send = send;
    this.recordings = new ServerRecordings(send, open);
    this.unlocked = false;  // whether its viewer is an admin
    this.objects = [];  // their names
    this.materials = [];
    this.session = null;  // of the chosen hand
    this.watched = null;  // the name of the scene
    this.waiting = null;  // the newest value of a knob that is dragged, until it is sent
    this.inputs = new Map();  // of a material
    this.linkInputs = new Map();
    this.law = new Map();  // choices of the chosen session: they and the next two show its values
    this.boundInputs = new Map();
    this.leadInputs = new Map();
    this.#build();
  }

  /** The panel was opened. */
  focus() {
    this.panel.querySelector('input:not(:disabled), [role=tab][aria-selected=true]')?.focus();
  }

  /** @param {{role: string, modes?: string[], observes?: boolean}} message the server's hello: a new connection */
  hello({role, modes = [], observes = false}) {
    this.#unlock(role === 'admin' && !observes);
    this.law.get('mode').replaceChildren(...modes.map((mode) => new Option(mode)));
    this.#say('', observes ? say('admin.observes') : '');
    if (observes) this.lock.hidden = true;
  }

  /** @param {{name: string, objects: {name: string}[]}} scene */
  scene({name, objects}) {
    if (name !== this.watched) this.recordings.forget();
    this.watched = name;
    const chosen = this.object.value;
    this.objects = objects.map(({name}) => name);
    this.object.replaceChildren(...this.objects.map((name) => new Option(name)));
    if (this.objects.includes(chosen)) this.object.value = chosen;
    this.#showMaterial();
  }

  /** @param {object} message of the types that are for this panel */
  take(message) {
    switch (message.type) {
      case 'materials':
        this.materials = message.objects ?? [];
        this.gravity.hidden = !message.gravity;
        message.gravity?.forEach((value, i) => fill(this.axes[i], value));
        this.#showMaterial();
        break;
      case 'recordings':
      case 'download':
        this.recordings.take(message);
        break;
      case 'admin':
        this.#unlock(true);
        this.#say('', say('admin.unlocked'));
        break;
      case 'changed':
        this.#say('', message.text);
        break;
      case 'refused':
        this.#say('error', message.text);
        this.recordings.refuse();
        document.activeElement.blur();  // What it holds is not so.
        this.#showSession(this.#ofSession());
        this.#showMaterial();
        break;
    }
  }

  /** @param {object | undefined} session of the chosen hand, from the server's table */
  choose(session) {
    const old = this.session;
    this.session = session ?? null;
    this.who.textContent = session ? say('admin.chosen', {number: session.number, client: session.client ?? '–'}) : say('admin.unchosen');
    this.evict.disabled = !session;
    const atClient = session?.side === 'client' && ['safe', 'any'].includes(session.laws_taken);
    const fixed = session?.side !== 'server' && !atClient;
    for (const input of this.law.values()) input.disabled = !session || fixed;
    this.more.hidden = !session;
    this.numbers.hidden = session?.side !== 'server';  // Those of a client's bound are its own.
    this.fixed.hidden = !session || !fixed;
    this.link.hidden = !session?.link_taken;
    this.lead.hidden = session?.lead_share == null;
    const other = session?.session !== old?.session;
    this.#showSession(this.#ofSession().filter(([field]) => other || session?.[field] !== old?.[field]));
    if (other) for (const input of this.linkInputs.values()) input.value = '';
    this.#showAnswer(session);
  }

  #build() {
    const {panel} = this;
    this.lock = make('form', {}, make('p', {}, say('admin.locked')),
      make('label', {}, make('span', {}, say('admin.token')), this.token = make('input', {type: 'password', autocomplete: 'off', required: true}), make('button', {}, say('admin.unlock'))));
    this.lock.onsubmit = (event) => {
      event.preventDefault();
      this.send({admin: this.token.value.trim()});
      this.token.value = '';
    };

    this.object = make('select', {ariaLabel: say('admin.object'), onchange: () => this.#showMaterial()});
    this.slider = make('input', {type: 'range', min: PER_DECADE, max: 5 * PER_DECADE, ariaLabel: say('admin.stiffness.slider')});
    this.slider.oninput = () => {
      const value = Number((10 ** (this.slider.value / PER_DECADE)).toPrecision(3));
      this.inputs.get('stiffness').value = value;
      this.#sendSoon({set: {object: this.object.value, stiffness: value}});
    };
    const rows = FIELDS.map(([field, unit, step]) => numberRow(this.inputs, [field, unit], {step, onchange: () => this.#set(field)}));
    rows.splice(1, 0, this.slider);

    this.axes = ['x', 'y', 'z'].map((axis) => make('input', {type: 'number', step: 'any', ariaLabel: say('admin.gravity.axis', {axis}), onchange: () => this.#setGravity()}));
    this.gravity = make('div', {hidden: true}, make('h3', {}, say('admin.gravity')), make('p', {className: 'axes'}, ...this.axes, make('i', {}, 'm/s²')));

    this.who = make('h3', {});
    const [mode, projection, storage, reference] = [
      ['mode', 'admin.mode', []],
      ['projection', 'admin.projection', ['cone', 'joint']],
      ['storage', 'admin.storage', ['minimal', 'elastic']],
      ['reference', 'admin.reference.name', ['zero', 'following']],
    ].map(([field, name, choices]) => {
      const choice = make('select', {ariaLabel: say(name), onchange: () => this.#setSession({[field]: choice.value})}, ...choices.map((name) => new Option(name)));
      this.law.set(field, choice);
      return choice;
    });
    this.fixed = make('p', {}, say('admin.fixed'));
    const numbers = BOUND.map((row) => numberRow(this.boundInputs, row, {placeholder: say('admin.default'), onchange: (event) => this.#setNumber(row[0], event)}));
    this.more = make('details', {hidden: true}, make('summary', {}, say('admin.numbers')),
      numbers.shift(), this.numbers = make('div', {}, make('label', {}, make('span', {}, say('admin.reference')), reference), ...numbers));
    this.link = make('div', {hidden: true}, make('h3', {}, say('admin.link')),
      ...LINK.map((row) => numberRow(this.linkInputs, row, {onchange: () => this.#setLink()})));
    this.lead = make('div', {hidden: true}, make('h3', {}, say('admin.lead')),
      numberRow(this.leadInputs, ['lead_share', ''], {max: 100, onchange: (event) => this.#setNumber('lead_share', event)}));
    this.answer = make('p', {className: 'answer'});
    this.evict = make('button', {onclick: () => this.send({evict: this.session.session})}, say('admin.evict'));
    const reload = make('button', {onclick: () => this.send({reload: true})}, say('admin.reload'));
    const record = make('button', {onclick: () => this.send({record: true}), title: say('admin.flight.hint')}, say('admin.flight'));

    const parts = {
      object: [this.object, make('fieldset', {}, ...rows)],
      hand: [this.who, make('fieldset', {}, make('p', {className: 'law'}, mode, ' ', projection, ' ', storage), this.fixed, this.more, this.link, this.lead, this.answer, make('p', {}, this.evict))],
      scene: [make('fieldset', {}, this.gravity, make('p', {}, reload), make('p', {}, record), this.recordings.element)],
    };
    this.said = make('output', {id: 'admin-said'});
    const pages = makeTabs('admin', parts, (name) => say(`admin.${name}`));
    this.knobs = panel.getElementsByTagName('fieldset');
    panel.append(this.lock, pages.tabs, ...pages.pages, this.said);
    this.#unlock(false);
    this.choose(undefined);
  }

  #unlock(admin) {
    this.unlocked = admin;
    this.lock.hidden = admin;
    this.recordings.element.hidden = !admin;
    if (!admin) this.recordings.forget();
    for (const knobs of this.knobs) {
      knobs.disabled = !admin;
      knobs.title = admin ? '' : say('admin.knob');
    }
  }

  #say(level, text) {
    this.said.dataset.level = level;
    this.said.textContent = text;
  }

  #showMaterial() {
    const material = this.materials[this.objects.indexOf(this.object.value)];
    if (!material || this.waiting) return;
    for (const [field] of FIELDS) fill(this.inputs.get(field), material[field]);
    fill(this.slider, PER_DECADE * Math.log10(material.stiffness));
  }

  #set(field) {
    const value = this.inputs.get(field).valueAsNumber;
    if (Number.isNaN(value)) return this.#showMaterial();
    const set = {object: this.object.value, [field]: value};
    // Dynamic friction may not be above static friction.
    const other = this.materials[this.objects.indexOf(this.object.value)];
    if (field === 'static_friction' && value < other?.dynamic_friction) set.dynamic_friction = value;
    if (field === 'dynamic_friction' && value > other?.static_friction) set.static_friction = value;
    return this.send({set});
  }

  /** Fields of the chosen session that inputs show. */
  #ofSession() {
    return [...this.law, ...this.boundInputs, ...this.leadInputs];
  }

  #showSession(inputs) {
    for (const [field, input] of inputs) fill(input, this.session?.[field] ?? '');
  }

  #setSession(fields) {
    this.send({set: {session: this.session.session, ...fields}});
  }

  #setNumber(field, {target}) {
    if (Number.isFinite(target.valueAsNumber)) this.#setSession({[field]: target.valueAsNumber});
  }

  /** What is not given is none. */
  #setLink() {
    this.#setSession(Object.fromEntries(LINK.map(([field, , scale]) => {
      const value = this.linkInputs.get(field).valueAsNumber;
      return [field, Number.isNaN(value) ? 0 : value / scale];
    })));
  }

  /** What the client of the chosen hand said to the newest change that it was asked for. */
  #showAnswer(session) {
    this.answer.hidden = !session?.asked;
    if (!session?.asked) return;
    this.answer.textContent = say(`admin.answer.${session.answer}`, session);
    this.answer.dataset.level = session.answer === 'refused' ? 'error' : '';
    if (session.answer !== 'refused') return;
    this.#showSession(this.law);
  }

  #setGravity() {
    const gravity = this.axes.map((input) => input.valueAsNumber);
    if (gravity.every(Number.isFinite)) this.send({set: {gravity}});
  }

  /** Sends the newest value after a while, so that a knob that is dragged sends few messages. */
  #sendSoon(message) {
    const asked = this.waiting !== null;
    this.waiting = message;
    if (asked) return;
    setTimeout(() => {
      this.send(this.waiting);
      this.waiting = null;
    }, PERIOD);
  }
}
