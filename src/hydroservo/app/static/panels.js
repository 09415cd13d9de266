// Time plots and the Bode plot: this run, the pinned ones, and a log.

import { byId, colour, element, options } from "./page.js";
import { Plot } from "./plot.js";

const OWN = ["line-1", "line-2", "line-3"]; // of this run's lines in a panel
export const PINNED = ["pin-1", "pin-2", "pin-3", "pin-4"];
const DASHES = [[6, 3], [2, 3], [9, 3, 2, 3], [1, 4]];
const HEIGHTS = [200, 130, 130, 150];

export class Panels {
  constructor(onPoint) {
    this.onPoint = onPoint;
    this.plots = [];
    this.magnitude = new Plot(byId("bode"), 190);
    this.phase = new Plot(byId("bode"), 150);
    this.curve = "open";
    byId("curve").addEventListener("change", () => {
      this.curve = byId("curve").value;
      this.bode(this.now, this.pinned);
    });
  }

  /** Draws a run over its pins and a log. */
  runs(run, pins, log) {
    const range = [0, run.duration];
    run.panels.forEach((panel, i) => {
      const plot = (this.plots[i] ??= new Plot(byId(i ? "more-panels" : "watch"), HEIGHTS[i] ?? 130, this.onPoint));
      plot.figure.hidden = false;
      plot.show({ title: panel.title, unit: panel.unit, across: "s", range, lines: linesOf(panel, run, pins, log), label: described(panel, run) });
    });
    for (const plot of this.plots.slice(run.panels.length)) plot.figure.hidden = true;
  }

  at(instant) {
    for (const plot of this.plots) plot.at(instant);
  }

  /** Draws a loop in frequency, over those of the pins. */
  bode(now, pinned) {
    this.now = now;
    this.pinned = pinned;
    byId("bode").classList.toggle("stale", now === null);
    if (!now) return;
    options(byId("curve"), now.curves.map(({ name, title }) => [name, title]), this.curve);
    const shown = [...pinned.map((one, i) => ({ ...one, pin: i })), { ...now, pin: null }];
    const range = [now.frequency[0], now.frequency.at(-1)];
    const drawn = (row) => shown.map((one) => ({
      x: one.frequency, y: one.rows[row(one)], name: one.pin === null ? "this loop" : one.title, ...look(one.pin, 0),
    }));
    const place = (one) => one.curves.findIndex(({ name }) => name === this.curve);
    const curve = now.curves[place(now)];
    const margins = now.margins.map(({ meaning, text }) => `${meaning} ${text}`).join(", ");
    this.magnitude.show({ title: "magnitude", unit: `dB${curve.unit ? ` re 1 ${curve.unit}` : ""}`, log: true, across: "Hz", range, bare: true,
      lines: drawn((one) => 2 * place(one)), label: `Magnitude over frequency, ${curve.title}. ${margins}` });
    this.phase.show({ title: "phase", unit: "°", log: true, across: "Hz", range, degrees: true,
      lines: drawn((one) => 2 * place(one) + 1).map((one) => ({ ...one, name: "" })), label: `Phase over frequency, ${curve.title}` });
    this.phase.figure.title = "Frequency in Hz";
    const entries = now.margins.flatMap(({ meaning, text }) => [element("dt", {}, meaning), element("dd", {}, text)]);
    byId("margins").classList.toggle("stale", now.sketched);
    byId("margins").replaceChildren(...(now.stable ? [] : [element("dt", {}, "small motions"), element("dd", { class: "bad" }, "unstable")]), ...entries);
  }

  /** Lowest and highest frequency that are shown [Hz]. */
  get band() {
    return [this.now.frequency[0], this.now.frequency.at(-1)];
  }

  /** Draws the curves anew, in the colours there are now. */
  redraw() {
    if (this.now) this.bode(this.now, this.pinned);
  }
}

function look(pin, i) {
  if (pin === null) return { colour: colour(OWN[i % OWN.length]), width: 1.8 };
  return { colour: colour(PINNED[pin % PINNED.length]), width: 1.4, dash: DASHES[pin % DASHES.length] };
}

function linesOf(panel, run, pins, log) {
  const found = [];
  for (const one of log?.lines ?? []) {
    if (panel.lines.some(({ path }) => path === one.path)) {
      const factor = run.factors[panel.title];
      found.push({ x: one.x, y: one.y.map((value) => value * factor), name: "log", colour: colour("log"), width: 1.2 });
    }
  }
  pins.forEach((pin, i) => {
    const theirs = pin.run?.panels.find(({ title }) => title === panel.title);
    const ratio = theirs ? run.factors[panel.title] / pin.run.factors[panel.title] : 1;
    for (const line of theirs?.lines ?? []) {
      if (line.path === "reference.value") continue;
      const y = ratio === 1 ? line.y : line.y.map((value) => value * ratio);
      found.push({ x: pin.run.time, y, name: line === theirs.lines.at(-1) ? pin.title : "", ...look(i, 0) });
    }
  });
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
  return `${panel.title} over ${run.duration} s: ${parts.join("; ")}`;
}
