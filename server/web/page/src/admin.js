// The admin's panel: knobs for materials, gravity and the chosen session. The server judges every value; what it refuses is said here.

const PERIOD = 150;  // [ms] between two messages of a knob that is dragged
const PER_DECADE = 100;  // steps of the stiffness slider

/** Fields of a material: name in messages, label, unit, step of the arrows. */
const FIELDS = [
  ['stiffness', 'Stiffness', 'N/m', 'any'],
  ['damping', 'Damping', 'N s/m', '0.1'],
  ['static_friction', 'Static friction', '', '0.05'],
  ['dynamic_friction', 'Dynamic friction', '', '0.05'],
  ['viscous_friction', 'Viscous friction', 'N s/m', '0.1'],
];

/** Of an emulated link: name in messages, label, unit, how many of the unit are one of the message. */
const LINK = [
  ['link_delay', 'Delay', 'ms', 1e3],
  ['link_jitter', 'Jitter', 'ms', 1e3],
  ['link_loss', 'Loss', '%', 100],
];

/** Numbers of a bound: name in messages and of a session, label, unit. The server judges them, and fills what is not given. */
const BOUND = [
  ['velocity_cutoff', 'Velocity cutoff', 'Hz'],  // First: it is the server's, whoever bounds.
  ['operator_damping', 'Operator’s damping', 'N s/m'],
  ['c1', 'c1', 'N/m'],
  ['c2', 'c2', 'N/m'],
  ['coupling_stiffness', 'Coupling stiffness', 'N/m'],
  ['coupling_damping', 'Coupling damping', 'N s/m'],
  ['tool_mass', 'Mass of its tool', 'kg'],
];

/** @param {string} tag @param {object} properties @param {...(Node | string)} children */
export function make(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** Puts a value into an input that nobody is using. */
function fill(input, value) {
  if (document.activeElement !== input) input.value = value;
}

export class Admin {
  /** @param {HTMLElement} panel @param {HTMLButtonElement} button that opens it @param {(message: object) => void} send */
  constructor(panel, button, send) {
    this.panel = panel;
    this.send = send;
    this.objects = [];  // their names
    this.materials = [];
    this.session = null;  // of the chosen hand
    this.waiting = null;  // the newest value of a knob that is dragged, until it is sent
    this.inputs = new Map();
    this.linkInputs = new Map();
    this.boundInputs = new Map();
    this.#build();
    button.onclick = () => {
      panel.hidden = !panel.hidden;
      button.setAttribute('aria-expanded', String(!panel.hidden));
      if (!panel.hidden) panel.querySelector('input:not(:disabled), select')?.focus();
    };
  }

  /** @param {{role: string, modes?: string[]}} message the server's hello: a new connection */
  hello({role, modes = []}) {
    this.#unlock(role === 'admin');
    this.mode.replaceChildren(...modes.map((mode) => new Option(mode)));
    this.#say('', '');
  }

  /** @param {{objects: {name: string}[]}} scene */
  scene({objects}) {
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
      case 'admin':
        this.#unlock(true);
        this.#say('', 'The token is that of an admin.');
        break;
      case 'changed':
        this.#say('', message.text);
        break;
      case 'refused':
        this.#say('error', message.text);
        document.activeElement.blur();  // What it holds is not so.
        fill(this.leadShare, this.session?.lead_share ?? '');
        for (const [field, input] of [...this.law, ...this.boundInputs]) fill(input, this.session?.[field] ?? '');
        this.#showMaterial();
        break;
    }
  }

  /** @param {object | undefined} session of the chosen hand, from the server's table */
  choose(session) {
    const old = this.session;
    this.session = session ?? null;
    this.who.textContent = session ? `Hand ${session.number}, ${session.client ?? '–'}` : 'No hand is chosen';
    this.evict.disabled = !session;
    const atClient = session?.side === 'client' && ['safe', 'any'].includes(session.laws_taken);
    const fixed = session?.side !== 'server' && !atClient;
    for (const [field, input] of this.law) {
      input.disabled = !session || fixed;
      if (session?.session !== old?.session || session?.[field] !== old?.[field]) fill(input, session?.[field] ?? '');
    }
    this.more.hidden = !session;
    this.numbers.hidden = session?.side !== 'server';  // Those of a client's bound are its own.
    for (const [field, input] of this.boundInputs) {
      if (session?.session !== old?.session || session?.[field] !== old?.[field]) fill(input, session?.[field] ?? '');
    }
    this.fixed.hidden = !session || !fixed;
    this.link.hidden = !session?.link_taken;
    this.lead.hidden = session?.lead_share == null;
    if (session?.session !== old?.session || session?.lead_share !== old?.lead_share) fill(this.leadShare, session?.lead_share ?? '');
    if (session?.session !== old?.session) for (const input of this.linkInputs.values()) input.value = '';
    this.#showAnswer(session);
  }

  #build() {
    const {panel} = this;
    this.lock = make('form', {}, make('label', {}, 'Token of an admin ', this.token = make('input', {type: 'password', autocomplete: 'off', required: true})),
      make('button', {}, 'Unlock'));
    this.lock.onsubmit = (event) => {
      event.preventDefault();
      this.send({admin: this.token.value.trim()});
      this.token.value = '';
    };

    this.object = make('select', {onchange: () => this.#showMaterial()});
    this.slider = make('input', {type: 'range', min: PER_DECADE, max: 5 * PER_DECADE, ariaLabel: 'Stiffness, 10 to 100 000 N/m'});
    this.slider.oninput = () => {
      const value = Number((10 ** (this.slider.value / PER_DECADE)).toPrecision(3));
      this.inputs.get('stiffness').value = value;
      this.#sendSoon({set: {object: this.object.value, stiffness: value}});
    };
    const rows = FIELDS.map(([field, label, unit, step]) => {
      const input = make('input', {type: 'number', step, min: 0, onchange: () => this.#set(field)});
      this.inputs.set(field, input);
      return make('label', {}, make('span', {}, label), input, make('i', {}, unit));
    });
    rows.splice(1, 0, this.slider);

    this.axes = ['x', 'y', 'z'].map((axis) => make('input', {type: 'number', step: 'any', ariaLabel: `Gravity ${axis}`, onchange: () => this.#setGravity()}));
    this.gravity = make('div', {hidden: true}, make('h3', {}, 'Gravity'), make('p', {className: 'axes'}, ...this.axes, make('i', {}, 'm/s²')));

    this.who = make('h3', {});
    this.mode = make('select', {ariaLabel: 'Mode of the bound', onchange: () => this.#setLaw('mode')});
    this.projection = make('select', {ariaLabel: 'Projection of contact_frame', onchange: () => this.#setLaw('projection')}, new Option('cone'), new Option('joint'));
    this.storage = make('select', {ariaLabel: 'Storage of contact_frame', onchange: () => this.#setLaw('storage')}, new Option('minimal'), new Option('elastic'));
    this.law = new Map([['mode', this.mode], ['projection', this.projection], ['storage', this.storage]]);
    this.fixed = make('p', {}, 'Its client bounds and takes no other law: start it anew with other options.');
    const boundRows = BOUND.map(([field, label, unit]) => {
      const input = make('input', {type: 'number', step: 'any', min: 0, placeholder: 'default', onchange: () => this.#setBound(field)});
      this.boundInputs.set(field, input);
      return make('label', {}, make('span', {}, label), input, make('i', {}, unit));
    });
    this.reference = make('select', {ariaLabel: 'Reference of passivity_control', onchange: () => this.#setLaw('reference')}, new Option('zero'), new Option('following'));
    this.law.set('reference', this.reference);
    this.more = make('details', {hidden: true}, make('summary', {}, 'Numbers'),
      boundRows.shift(), this.numbers = make('div', {}, make('label', {}, make('span', {}, 'Reference'), this.reference), ...boundRows));
    const linkRows = LINK.map(([field, label, unit]) => {
      const input = make('input', {type: 'number', step: 'any', min: 0, onchange: () => this.#setLink()});
      this.linkInputs.set(field, input);
      return make('label', {}, make('span', {}, label), input, make('i', {}, unit));
    });
    this.link = make('div', {hidden: true}, make('h3', {}, 'Emulated link, each way'), ...linkRows);
    this.leadShare = make('input', {type: 'number', step: 'any', min: 0, max: 100, onchange: () => this.#setLead()});
    this.lead = make('div', {hidden: true}, make('h3', {}, 'Lead of the robot'),
      make('label', {}, make('span', {}, 'Share (0: alone)'), this.leadShare, make('i', {}, '')));
    this.answer = make('p', {className: 'answer'});
    this.evict = make('button', {onclick: () => this.send({evict: this.session.session})}, 'Evict');
    this.reload = make('button', {onclick: () => this.send({reload: true})}, 'Reload the scene’s file');

    this.knobs = make('div', {}, make('h3', {}, 'Object'), this.object, ...rows, this.gravity, this.who,
      make('p', {className: 'law'}, this.mode, ' ', this.projection, ' ', this.storage, ' ', this.evict), this.more, this.fixed, this.link, this.lead, this.answer,
      make('p', {}, this.reload));
    this.said = make('output', {id: 'admin-said'});
    panel.append(this.lock, this.knobs, this.said);
    this.#unlock(false);
    this.choose(undefined);
  }

  #unlock(admin) {
    this.lock.hidden = admin;
    this.knobs.hidden = !admin;
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
    // One may not be above the other.
    const other = this.materials[this.objects.indexOf(this.object.value)];
    if (field === 'static_friction' && value < other?.dynamic_friction) set.dynamic_friction = value;
    if (field === 'dynamic_friction' && value > other?.static_friction) set.static_friction = value;
    return this.send({set});
  }

  #setLaw(field) {
    this.send({set: {session: this.session.session, [field]: this.law.get(field).value}});
  }

  #setBound(field) {
    const value = this.boundInputs.get(field).valueAsNumber;
    if (Number.isFinite(value)) this.send({set: {session: this.session.session, [field]: value}});
  }

  /** What is not given is none. */
  #setLink() {
    const set = {session: this.session.session};
    for (const [field, , , scale] of LINK) {
      const value = this.linkInputs.get(field).valueAsNumber;
      set[field] = Number.isNaN(value) ? 0 : value / scale;
    }
    this.send({set});
  }

  #setLead() {
    const share = this.leadShare.valueAsNumber;
    if (Number.isFinite(share)) this.send({set: {session: this.session.session, lead_share: share}});
  }

  /** What the client of the chosen hand said to the newest change that it was asked for. */
  #showAnswer(session) {
    this.answer.hidden = !session?.asked;
    if (!session?.asked) return;
    const said = {waiting: 'is being asked for', taken: 'has taken', refused: 'has refused'}[session.answer];
    this.answer.textContent = `Its client ${said}: ${session.asked}`;
    this.answer.dataset.level = session.answer === 'refused' ? 'error' : '';
    if (session.answer !== 'refused') return;
    for (const [field, input] of this.law) fill(input, session[field] ?? '');
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
