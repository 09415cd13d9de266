// Time plots and the Bode plot: this run, and the pinned ones.

import { NONE, byId, colour, element, options } from "./page.js";
import { Plot } from "./plot.js";

const OWN = ["line-1", "line-2", "line-3"]; // of this run's lines in a panel
export const PINNED = ["pin-1", "pin-2", "pin-3", "pin-4"];
const DASHES = [[6, 3], [2, 3], [9, 3, 2, 3], [1, 4]];
const HEIGHTS = [200, 130, 130, 150];

export class Panels {
  constructor(onPoint) {
    this.onPoint = onPoint;
    this.plots = [];
    this.now = null; // the loop in frequency that is drawn
    this.waiting = true; // for that of what is entered
    this.magnitude = new Plot(byId("bode"), 190);
    this.phase = new Plot(byId("bode"), 150);
    this.curve = "open";
    byId("curve").addEventListener("change", () => {
      this.curve = byId("curve").value;
      this.redraw();
    });
  }

  /** Draws a run over its pins. */
  runs(run, pins) {
    const range = [0, run.duration];
    run.panels.forEach((panel, i) => {
      const plot = (this.plots[i] ??= new Plot(byId(i ? "more-panels" : "watch"), HEIGHTS[i] ?? 130, this.onPoint));
      plot.figure.hidden = false;
      const theirs = pins.map((pin) => inUnitOf(panel, pin)).filter(Boolean);
      const extent = together([panel, ...theirs].map((one) => one.extent));
      const clipped = [panel.clipped, ...theirs.map((one) => one.clipped && `${one.name} ${one.clipped}`)].filter(Boolean).join("; ");
      plot.show({ title: panel.title, unit: panel.unit, across: "s", range, extent, clipped, lines: linesOf(panel, run, theirs, pins), label: described(panel, run) });
    });
    for (const plot of this.plots.slice(run.panels.length)) plot.figure.hidden = true;
  }

  at(instant) {
    for (const plot of this.plots) plot.at(instant);
  }

  /** Something was entered that neither run nor curves are of yet: no number of theirs stays. */
  pending() {
    this.waiting = true;
    for (const plot of [...this.plots, this.magnitude, this.phase]) plot.unsaid();
    byId("bode").classList.add("stale");
    byId("bode-problem").hidden = true;
    byId("bode-notes").replaceChildren();
    for (const one of byId("margins").querySelectorAll("dd")) one.replaceWith(element("dd", {}, NONE));
  }

  /** Draws a loop in frequency, over those of the pins; null draws these alone. */
  bode(now, pinned) {
    this.now = now;
    this.pinned = pinned;
    this.waiting = Boolean(now?.sketched);
    const shown = [...pinned.map((one, i) => ({ ...one, pin: i })), ...(now ? [{ ...now, pin: null }] : [])];
    const margins = now?.margins ?? [];
    byId("bode").classList.remove("stale");
    byId("bode").hidden = !shown.length;
    if (now) byId("frequency").querySelector(".before").hidden = false;
    if (!now?.sketched) tell(now, margins);
    if (!shown.length) return;
    const [{ curves, frequency }] = shown.slice(-1);
    options(byId("curve"), curves.map(({ name, title }) => [name, title]), this.curve);
    const range = [frequency[0], frequency.at(-1)];
    const drawn = (row) => shown.map((one) => ({
      x: one.frequency, y: one.rows[row(one)], name: one.pin === null ? "this loop" : one.title, ...look(one.pin, 0),
    }));
    const place = (one) => one.curves.findIndex(({ name }) => name === this.curve);
    const curve = curves[place({ curves })];
    const said = margins.map(({ meaning, text }) => `${meaning} ${text}`).join(", ");
    this.magnitude.show({ title: "magnitude", unit: `dB${curve.unit ? ` re 1 ${curve.unit}` : ""}`, log: true, across: "Hz", range, bare: true,
      lines: drawn((one) => 2 * place(one)), label: `Magnitude over frequency, ${curve.title}. ${said}` });
    this.phase.show({ title: "phase", unit: "°", log: true, across: "Hz", range, degrees: true,
      lines: drawn((one) => 2 * place(one) + 1).map((one) => ({ ...one, name: "" })), label: `Phase over frequency, ${curve.title}` });
    this.phase.figure.title = "Frequency in Hz";
  }

  /** Lowest and highest frequency that are shown [Hz]. */
  get band() {
    return [this.now.frequency[0], this.now.frequency.at(-1)];
  }

  /** Draws the curves anew, in the colours there are now. */
  redraw() {
    if (!this.pinned) return;
    const { waiting } = this;
    this.bode(this.now, this.pinned);
    if (waiting) this.pending();
  }
}

function look(pin, i) {
  if (pin === null) return { colour: colour(OWN[i % OWN.length]), width: 1.8 };
  return { colour: colour(PINNED[pin % PINNED.length]), width: 1.4, dash: DASHES[pin % DASHES.length] };
}

/** The margins of a loop, and what is said of it; nothing where there is none. */
function tell(now, margins) {
  byId("margins").replaceChildren(...margins.flatMap(({ meaning, text }) => [element("dt", {}, meaning), element("dd", {}, text)]));
  byId("bode-notes").replaceChildren(...(now?.warnings ?? []).map((one) => element("p", {}, one)));
}

/** The least and the largest of some extents; none where nothing has one. */
function together(extents) {
  const there = extents.filter(Boolean);
  return there.length ? [Math.min(...there.map(([low]) => low)), Math.max(...there.map(([, high]) => high))] : null;
}

/** A pinned run's lines beside those of a panel, in its unit. */
function inUnitOf(panel, pin) {
  const theirs = pin.run?.panels.find(({ title }) => title === panel.title);
  if (!theirs) return null;
  const ratio = panel.factor / theirs.factor;
  const lines = theirs.lines.map((line) => ({ ...line, y: ratio === 1 ? line.y : line.y.map((value) => value * ratio) }));
  return { name: pin.title, time: pin.run.time, lines, clipped: theirs.clipped, extent: theirs.extent?.map((one) => one * ratio) };
}

function linesOf(panel, run, theirs, pins) {
  const found = [];
  for (const pin of theirs) {
    const i = pins.findIndex(({ title }) => title === pin.name);
    for (const line of pin.lines) {
      if (line.path === "reference.value") continue;
      found.push({ x: pin.time, y: line.y, name: line === pin.lines.at(-1) ? pin.name : "", ...look(i, 0) });
    }
  }
  const order = panel.lines.length > 1 && panel.lines[0].path === "reference.value" ? [1, 0] : panel.lines.map((_, i) => i);
  panel.lines.map((line, i) => ({ x: run.time, y: line.y, name: line.name, ...look(null, order[i]), ...(line.path === "reference.value" ? { dash: [5, 4] } : {}) }))
    .sort((one, other) => order.length > 1 && (one.dash ? 1 : 0) - (other.dash ? 1 : 0))
    .forEach((line) => found.push(line));
  return found;
}

/** What a plot shows, in words. */
function described(panel, run) {
  const parts = panel.lines.map(({ name, y }) => {
    let [low, high] = [Infinity, -Infinity];
    for (const value of y) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return `${name} from ${low.toPrecision(3)} to ${high.toPrecision(3)} ${panel.unit}`;
  });
  return [`${panel.title} over ${run.duration} s: ${parts.join("; ")}`, panel.clipped && `clipped: ${panel.clipped}`].filter(Boolean).join("; ");
}
