// Follows what is entered: one request at a time, always with the latest numbers.

const PATIENCE = 400; // ms after which the plots are shown as not up to date

export class Follow {
  /**
   * @param {string} name under which the browser's own clock keeps how long it took
   * @param {() => Promise<void>} answer asks, and draws
   * @param {(error: Error) => void} fail
   * @param {() => void} [late] told when it takes long
   */
  constructor(name, answer, fail, late = () => {}) {
    Object.assign(this, { name, answer, fail, late });
    this.since = null; // when the oldest change was made that is not drawn
    this.busy = false;
  }

  /** Something changed at an instant of the page's clock [ms]. */
  ask(when) {
    this.since ??= when;
    if (!this.busy) this.go();
  }

  async go() {
    this.busy = true;
    while (this.since !== null) {
      const start = this.since;
      this.since = null;
      const timer = setTimeout(this.late, PATIENCE);
      try {
        await this.answer();
        const drawn = performance.now();
        await painted();
        performance.measure(this.name, { start, end: performance.now(), detail: { drawn } });
      } catch (error) {
        this.fail(error);
      } finally {
        clearTimeout(timer);
      }
    }
    this.busy = false;
  }
}

/** After the frame in which what was drawn is shown. */
function painted() {
  if (document.hidden) return Promise.resolve();
  return new Promise((done) => requestAnimationFrame(() => done())); // its turn comes after that of the plots
}
