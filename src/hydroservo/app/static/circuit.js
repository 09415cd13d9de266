// The machine's circuit, as the server draws it, with a run's values; its parts lead to their fields.

import { NONE, byId } from "./page.js";

const MOVES = { // as sheet.py has them
  switch: null, // in no time, which the style makes short
  slide: (value) => `translate(${value} 0)`,
  turn: (value, x, y) => `rotate(${value} ${x} ${y})`,
  stretch: (value, x) => `translate(${x} 0) scale(${value} 1) translate(${-x} 0)`,
};
const within = (share) => Math.min(1, Math.max(0, share));

export class Circuit {
  constructor(onPart) {
    this.onPart = onPart;
    this.text = "";
  }

  /** Draws a run's machine. */
  show(run) {
    this.run = run;
    if (run.circuit !== this.text) this.draw(run.circuit);
    this.nodes = this.svg.dataset.pressures.split(" ").filter(Boolean).map((node) => node.split("="));
    const largest = this.nodes.map(([, of]) => this.extents(of).map(Math.abs)).flat();
    this.largest = Math.max(1, ...largest); // Pa
  }

  draw(text) {
    this.text = text;
    this.svg = document.importNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true);
    for (const part of this.svg.querySelectorAll("[data-part]")) this.link(part);
    this.values = this.svg.querySelectorAll("[data-signal]");
    this.moving = Object.keys(MOVES).flatMap((how) => [...this.svg.querySelectorAll(`[data-${how}]`)].map((part) => ({
      part, move: MOVES[how], path: part.dataset[how], ends: part.dataset.ends.split(" ").map(Number), at: part.dataset.at.split(" "),
    })));
    byId("drawing").replaceChildren(this.svg);
  }

  /** Has a part open its parameters. */
  link(part) {
    const name = part.querySelector("title").textContent;
    for (const [key, value] of Object.entries({ role: "button", tabindex: "0", "aria-label": `${name}: show its parameters` })) part.setAttribute(key, value);
    part.addEventListener("click", () => this.onPart(part.dataset.part));
    part.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      this.onPart(part.dataset.part);
    });
  }

  /** Takes the values away. */
  blank() {
    this.run = null;
    this.text = ""; // what is constant is drawn anew
    for (const one of byId("drawing").querySelectorAll(".value")) one.textContent = "";
  }

  /** The values at a point of the run. */
  at(i) {
    const { run } = this;
    if (!run) return;
    for (const place of this.values) place.textContent = this.reading(place.dataset.signal, i);
    for (const { part, move, path, ends: [low, high, start, end], at } of this.moving) {
      const value = this.value(path, i);
      if (!Number.isFinite(value)) continue;
      const share = within((value - low) / (high - low) || 0);
      if (move) part.setAttribute("transform", move(start + (end - start) * share, ...at));
      else part.style.transform = `translate(${value > high ? end : value < low ? start : 0}px)`;
    }
    for (const [node, of] of this.nodes) {
      const share = within(this.value(of, i) / this.largest);
      for (const line of this.svg.querySelectorAll(`[data-port="${node}"]`)) if (Number.isFinite(share)) line.style.setProperty("--share", share);
    }
  }

  /** A number as it is read; "" where the run has no such signal. */
  reading(path, i) {
    const signal = this.run.byPath.get(path);
    if (!signal) return "";
    if (!Number.isFinite(signal.y[i])) return NONE; // the run was lost before
    return `${Number(signal.y[i].toPrecision(3)).toString().replace("-", "\u2212")} ${signal.unit}`;
  }

  /** A signal, or a constant, in SI units; nan where the run has no such signal. */
  value(path, i) {
    const signal = this.run.byPath.get(path);
    return signal ? signal.y[i] / signal.factor : Number.parseFloat(path);
  }

  /** How far a signal, or a constant, goes, in SI units. */
  extents(path) {
    const { extent, factor } = this.run.byPath.get(path) ?? {};
    return extent ? extent.map((one) => one / factor) : [Number.parseFloat(path) || 0];
  }
}
