// What the user chose: a scenario and changes in it. It lives in this tab, and survives a reload.

const KEY = "hydroservo";
const MOST = 200; // steps of undo

const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

export class State {
  constructor(onChange) {
    this.onChange = onChange;
    this.version = 0; // another one after each change
    this.clear({ name: "" }, {});
  }

  clear(source, changes) {
    this.source = source; // {name} of a scenario, or {text, title}
    this.changes = changes; // by dotted path, as --set takes them
    this.answered = null; // the last source and changes that the server ran
    this.past = []; // of those
    this.future = [];
    this.pins = [];
    this.signals = [];
  }

  /** What the server is asked with; an error is said in the units of what it ran before. */
  get request() {
    const before = this.answered ? { before: this.answered.changes } : {};
    return { ...(this.source.text ? { text: this.source.text } : { name: this.source.name }), changes: this.changes, ...before };
  }

  get snapshot() {
    return { source: this.source, changes: { ...this.changes } };
  }

  /** Whether what is chosen is what the server ran. */
  get valid() {
    return same(this.snapshot, this.answered);
  }

  /** Changes while a slider moves, which undo takes as one step. */
  live(changes) {
    this.changes = { ...this.changes, ...changes };
    this.version += 1;
  }

  /** The server ran what is chosen: undo may come back to it. */
  accept() {
    this.answered = this.snapshot;
    this.keep();
  }

  /** A step that undo takes back; what is drawn already need not be told. */
  commit(next = this, tell = true) {
    if (this.answered && !same(this.answered, this.past.at(-1))) this.past.push(this.answered);
    this.past.splice(0, this.past.length - MOST);
    this.future = [];
    this.source = next.source ?? this.source;
    this.changes = next.changes ?? this.changes;
    this.keep();
    if (!tell) return;
    this.version += 1;
    this.onChange();
  }

  /** Goes to a state that ran; the one that is left is kept if it ran too. */
  move(from, to) {
    if (!from.length) return;
    if (this.valid) to.push(this.answered);
    this.answered = from.pop();
    Object.assign(this, { source: this.answered.source, changes: { ...this.answered.changes } });
    this.version += 1;
    this.keep();
    this.onChange();
  }

  undo() {
    this.move(this.past, this.future);
  }

  redo() {
    this.move(this.future, this.past);
  }

  keep() {
    const { source, changes, answered, past, future, signals } = this;
    const pins = this.pins.map(({ source, changes, title }) => ({ source, changes, title }));
    try {
      sessionStorage.setItem(KEY, JSON.stringify({ source, changes, answered, past, future, pins, signals }));
    } catch {
      sessionStorage.removeItem(KEY); // more than the browser keeps: a reload begins anew
    }
  }

  /** Takes up what was there before a reload; says whether there was anything. */
  restore() {
    try {
      const kept = JSON.parse(sessionStorage.getItem(KEY));
      if (!kept) return false;
      Object.assign(this, kept);
      return true;
    } catch {
      return false;
    }
  }
}
