// What the user chose: a scenario and changes in it. It lives in this tab, and survives a reload.

const KEY = "hydroservo";
const MOST = 200; // steps of undo

export class State {
  constructor(onChange) {
    this.onChange = onChange;
    this.clear({ name: "" }, {});
  }

  clear(source, changes) {
    this.source = source; // {name} of a scenario, or {text, title}
    this.changes = changes; // by dotted path, as --set takes them
    this.past = [];
    this.future = [];
    this.pins = [];
    this.signals = [];
    this.before = null;
  }

  /** What the server is asked with. */
  get request() {
    return { ...(this.source.text ? { text: this.source.text } : { name: this.source.name }), changes: this.changes };
  }

  get snapshot() {
    return { source: this.source, changes: { ...this.changes } };
  }

  /** Changes while a slider moves, which undo takes as one step. */
  live(changes) {
    this.before ??= this.snapshot;
    this.changes = { ...this.changes, ...changes };
  }

  /** A step that undo takes back; what is drawn already need not be told. */
  commit(next = this, tell = true) {
    this.past.push(this.before ?? this.snapshot);
    this.past.splice(0, this.past.length - MOST);
    this.before = null;
    this.future = [];
    this.source = next.source ?? this.source;
    this.changes = next.changes ?? this.changes;
    this.keep();
    if (tell) this.onChange();
  }

  move(from, to) {
    const there = from.pop();
    if (!there) return;
    to.push(this.snapshot);
    this.source = there.source;
    this.changes = there.changes;
    this.before = null;
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
    const { source, changes, past, future, signals } = this;
    const pins = this.pins.map(({ source, changes, title }) => ({ source, changes, title }));
    try {
      sessionStorage.setItem(KEY, JSON.stringify({ source, changes, past, future, pins, signals }));
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
