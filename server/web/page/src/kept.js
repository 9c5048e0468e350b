// Values that the browser keeps for this page. One that keeps none (cookies blocked, a frame in a sandbox) throws instead: then a value
// lasts as long as the page.

class Kept {
  #values = new Map();

  /** @param {'localStorage' | 'sessionStorage'} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @param {string} key @returns {string | null} */
  get(key) {
    if (this.#values.has(key)) return this.#values.get(key);
    try {
      return window[this.storage].getItem(key);
    } catch {
      return null;
    }
  }

  /** @param {string} key @param {string} value */
  set(key, value) {
    this.#values.set(key, value);
    try {
      window[this.storage].setItem(key, value);
    } catch {
      // It lasts as long as the page.
    }
  }

  /** @param {string} key */
  remove(key) {
    this.#values.delete(key);
    try {
      window[this.storage].removeItem(key);
    } catch {
      // There was nothing to remove.
    }
  }
}

export const forSession = new Kept('sessionStorage');
export const forGood = new Kept('localStorage');
