// Lines on a canvas, with axes: some thousand points in a few milliseconds.

import { colour, element } from "./page.js";

const MARGIN = { left: 56, right: 10, top: 24, bottom: 22 };
const CROWDED = 3; // points to a pixel across, from which on not each is drawn
const FAR = 50; // heights of a plot, beyond which a canvas need not draw
const ROOM = 12; // px between two ticks' texts, at least

export class Plot {
  /**
   * @param {HTMLElement} parent where the plot goes
   * @param {number} height px
   * @param {(x: number) => void} [onPoint] told the abscissa under the pointer
   */
  constructor(parent, height, onPoint) {
    this.figure = document.createElement("figure");
    this.figure.className = "plot";
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.style.height = `${height}px`;
    this.note = element("figcaption", { class: "about", hidden: true });
    this.figure.append(this.canvas, this.note);
    parent.append(this.figure);
    this.height = height;
    this.spec = null;
    this.cursor = null;
    this.width = 0;
    new ResizeObserver(([{ contentRect }]) => {
      this.width = contentRect.width;
      this.draw();
    }).observe(this.figure);
    if (onPoint) this.listen(onPoint);
  }

  listen(onPoint) {
    const told = (event) => {
      if (event.pointerType !== "mouse" && !event.buttons) return;
      const box = this.canvas.getBoundingClientRect();
      if (this.scale) onPoint(this.scale.xAt(event.clientX - box.left));
    };
    this.canvas.addEventListener("pointermove", told);
    this.canvas.addEventListener("pointerdown", told);
  }

  /**
   * @param {object} spec title, unit, label (for those who do not see), x range, log, unit across, and lines of
   *   {x, y, colour, dash, width, name}; the extent of their ordinates, and what of them is clipped by it
   */
  show(spec) {
    this.spec = spec;
    this.canvas.setAttribute("aria-label", spec.label);
    this.note.textContent = `clipped: ${spec.clipped}`;
    this.note.hidden = !spec.clipped;
    this.draw();
  }

  /** What it shows is of an earlier loop: its numbers are no longer said. */
  unsaid() {
    this.note.hidden = true;
    if (this.spec) this.canvas.setAttribute("aria-label", `${this.spec.title} of the loop before`);
  }

  at(x) {
    this.cursor = x;
    this.draw();
  }

  /** Draws in the next frame, once however often it is asked. */
  draw() {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.paint();
    });
  }

  paint() {
    const { width } = this;
    if (!this.spec || !width) return;
    const ratio = window.devicePixelRatio || 1;
    const [w, h] = [Math.round(width * ratio), Math.round(this.height * ratio)];
    if (this.canvas.width !== w || this.canvas.height !== h) Object.assign(this.canvas, { width: w, height: h });
    const g = this.canvas.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, this.height);
    const ink = { text: colour("muted"), grid: colour("grid"), strong: colour("text") };
    this.scale = scaleOf(this.spec, width, this.height);
    axes(g, this.spec, this.scale, width, this.height, ink);
    lines(g, this.spec, this.scale, width, this.height);
    legend(g, this.spec, width, ink);
    if (this.cursor !== null) cursorLine(g, this.scale, this.cursor, this.height, ink);
  }
}

function scaleOf(spec, width, height) {
  const [x0, x1] = spec.log ? spec.range.map(Math.log10) : spec.range;
  const [y0, y1] = aired(spec.extent ?? extent(spec));
  const inner = { w: width - MARGIN.left - MARGIN.right, h: height - MARGIN.top - MARGIN.bottom };
  const place = (x) => MARGIN.left + (inner.w * (x - x0)) / (x1 - x0 || 1);
  return {
    y0, y1, x0, x1, inner,
    x: spec.log ? (x) => place(Math.log10(x)) : place,
    y: (y) => MARGIN.top + inner.h * (1 - Math.min(FAR, Math.max(-FAR, (y - y0) / (y1 - y0)))),
    xAt: (px) => x0 + ((px - MARGIN.left) / inner.w) * (x1 - x0),
  };
}

/** The least and largest ordinate. */
function extent(spec) {
  let [low, high] = [Infinity, -Infinity];
  for (const { y } of spec.lines) {
    for (let i = 0; i < y.length; i++) {
      const value = y[i];
      if (value < low && value > -1e30) low = value;
      if (value > high && value < 1e30) high = value;
    }
  }
  return [low, high];
}

/** An extent with some air. */
function aired([low, high]) {
  if (!(low <= high)) return [-1, 1];
  const air = high > low ? 0.06 * (high - low) : Math.max(Math.abs(high) * 0.1, 1e-6);
  return [low - air, high + air];
}

export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough) ?? rough;
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return { found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

export function written(value, digits) {
  const small = Math.abs(value) < 10 ** -digits / 2 ? 0 : value;
  const text = Math.abs(small) >= 1e5 ? small.toExponential(1) : small.toFixed(Math.min(digits, 8));
  return text.replace("-", "\u2212");
}

function axes(g, spec, scale, width, height, ink) {
  g.font = "12px system-ui, sans-serif";
  g.lineWidth = 1;
  g.strokeStyle = ink.grid;
  g.fillStyle = ink.text;
  const bottom = height - MARGIN.bottom;
  const vertical = spec.degrees ? degrees(scale) : ticks(scale.y0, scale.y1, scale.inner.h / 26);
  g.textAlign = "right";
  g.textBaseline = "middle";
  for (const y of vertical.found) {
    rule(g, MARGIN.left, scale.y(y), width - MARGIN.right, scale.y(y));
    g.fillText(written(y, vertical.digits), MARGIN.left - 6, scale.y(y));
  }
  g.textAlign = "center";
  g.textBaseline = "top";
  const across = spec.log ? decades(scale) : ticks(scale.x0, scale.x1, scale.inner.w / 80);
  if (spec.bare) across.found.forEach((x) => rule(g, scale.x(x), MARGIN.top, scale.x(x), bottom));
  else ticked(g, spec, scale, width, bottom, across);
}

/** Rules across with their numbers, the last with its unit. */
function ticked(g, spec, scale, width, bottom, across) {
  const shown = [];
  for (const x of across.found) {
    const place = scale.x(x);
    rule(g, place, MARGIN.top, place, bottom);
    const text = spec.log ? String(Number(x.toPrecision(1))) : written(x, across.digits);
    const half = g.measureText(text).width / 2;
    if (place - half < (shown.at(-1)?.end ?? -Infinity) + ROOM || spec.log && !/^0?\.?0*[125]0*$/.test(text)) continue;
    shown.push({ place, text, end: place + half });
  }
  shown.forEach(({ place, text }, i) => {
    const whole = i === shown.length - 1 ? `${text} ${spec.across}` : text;
    g.fillText(whole, Math.min(place, width - g.measureText(whole).width / 2 - 2), bottom + 5);
  });
}

function degrees(scale) {
  const step = [15, 30, 45, 90, 180, 360].find((one) => (scale.y1 - scale.y0) / one <= scale.inner.h / 28) ?? 360;
  const found = [];
  for (let y = Math.ceil(scale.y0 / step) * step; y <= scale.y1; y += step) found.push(y);
  return { found, digits: 0 };
}

function decades(scale) {
  const found = [];
  for (let p = Math.floor(scale.x0); p <= scale.x1; p++) {
    for (let k = 1; k < 10; k++) {
      const x = k * 10 ** p;
      if (Math.log10(x) >= scale.x0 - 1e-9 && Math.log10(x) <= scale.x1 + 1e-9) found.push(x);
    }
  }
  return { found, digits: 0 };
}

function rule(g, x0, y0, x1, y1) {
  g.beginPath();
  g.moveTo(Math.round(x0) + 0.5, Math.round(y0) + 0.5);
  g.lineTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
  g.stroke();
}

function lines(g, spec, scale, width, height) {
  g.save();
  g.beginPath();
  g.rect(MARGIN.left, MARGIN.top, width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom);
  g.clip();
  for (const line of spec.lines) {
    g.strokeStyle = line.colour;
    g.lineWidth = line.width ?? 1.6;
    g.setLineDash(line.dash ?? []);
    g.beginPath();
    if (line.y.length > CROWDED * scale.inner.w) crowded(g, line, scale);
    else every(g, line, scale);
    g.stroke();
  }
  g.restore();
}

function every(g, line, scale) {
  let down = false;
  for (let i = 0; i < line.y.length; i++) {
    const y = scale.y(line.y[i]);
    if (!Number.isFinite(y)) {
      down = false;
      continue;
    }
    const x = scale.x(line.x[i]);
    if (down) g.lineTo(x, y);
    else g.moveTo(x, y);
    down = true;
  }
}

/** A line of many points to each pixel across: the least and the largest of them, as they come. */
function crowded(g, { x, y }, scale) {
  for (let i = 0, begun = false; i < y.length; begun = true) {
    const column = Math.floor(scale.x(x[i]));
    let [least, most] = [i, i];
    for (; i < y.length && Math.floor(scale.x(x[i])) === column; i++) {
      if (!(y[i] >= y[least])) least = i;
      if (!(y[i] <= y[most])) most = i;
    }
    for (const at of least < most ? [least, most] : [most, least]) {
      if (!Number.isFinite(y[at])) continue;
      if (begun || at !== Math.min(least, most)) g.lineTo(scale.x(x[at]), scale.y(y[at]));
      else g.moveTo(scale.x(x[at]), scale.y(y[at]));
    }
  }
}

function legend(g, spec, width, ink) {
  g.textBaseline = "alphabetic";
  g.textAlign = "left";
  g.fillStyle = ink.strong;
  g.font = "600 13px system-ui, sans-serif";
  const title = spec.unit ? `${spec.title} [${spec.unit}]` : spec.title;
  g.fillText(title, 4, 15);
  let x = g.measureText(title).width + 20;
  g.font = "12px system-ui, sans-serif";
  for (const line of spec.lines) {
    if (!line.name) continue;
    const size = g.measureText(line.name).width;
    if (x + size + 26 > width) break;
    g.strokeStyle = line.colour;
    g.lineWidth = 2.4;
    g.setLineDash(line.dash ?? []);
    g.beginPath();
    g.moveTo(x, 11);
    g.lineTo(x + 18, 11);
    g.stroke();
    g.setLineDash([]);
    g.fillText(line.name, x + 22, 15);
    x += size + 38;
  }
}

function cursorLine(g, scale, x, height, ink) {
  g.strokeStyle = ink.strong;
  g.globalAlpha = 0.55;
  g.lineWidth = 1;
  rule(g, scale.x(x), MARGIN.top, scale.x(x), height - MARGIN.bottom);
  g.globalAlpha = 1;
}
