"use strict";
// Runs a loop sample by sample in WebAssembly, and draws what comes of it. Numbers are in SI units until shown.
const known = JSON.parse(document.getElementById("data").textContent);
const code = Uint8Array.from(atob(document.getElementById("code").textContent), (one) => one.charCodeAt(0));
const loop = new WebAssembly.Instance(new WebAssembly.Module(code)).exports;
const row = new Float64Array(loop.memory.buffer, loop.row(), known.width);
const given = new Float64Array(loop.memory.buffer, loop.sliders(), known.sliders.length);
const rows = Math.floor((known.samples - 1) / known.stride) + 1;
const span = (known.samples - 1) * known.period;
const columns = known.columns, values = known.sliders.map((one) => one.value);
const looks = {
  demand: { name: "demand", colour: "--line-2" }, signal: { name: "signal", colour: "--line-1" },
  error: { name: "error", colour: "--line-1" }, command: { name: "command", colour: "--line-1" },
};
const SLICE = 30; // ms of computing between two pictures
let turn = 0, base = null, now = null, pointed = NaN;

const read = (one, si) => one.factor * si - one.zero;
function text(x, digits = 4) {
  if (Number.isNaN(x)) return "–";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  const short = Number(x.toPrecision(digits));
  return (short !== 0 && (Math.abs(short) < 1e-3 || Math.abs(short) >= 1e6) ? short.toExponential() : String(short)).replace("-", "−");
}
const withUnit = (one, si) => (one.unit ? `${text(read(one, si))} ${one.unit}` : text(read(one, si)));
function made(tag, parent, attributes = {}, words = "") {
  const one = parent.appendChild(document.createElement(tag));
  for (const [name, value] of Object.entries(attributes)) one.setAttribute(name, value);
  one.textContent = words;
  return one;
}

// The run: in slices, so that the page answers while a long one computes; a newer one ends it.
async function run() {
  const own = ++turn, started = performance.now();
  const found = { demand: [], signal: [], command: [], error: [], lost: NaN, done: 0, metrics: null };
  given.set(values);
  loop.begin();
  let until = started + SLICE;
  for (let i = 0; i < rows; i++) {
    const reached = loop.advance(i * known.stride);
    if (reached < i * known.stride) { found.lost = reached * known.period; break; }
    found.demand.push(row[columns.demand]); found.signal.push(row[columns.signal]); found.command.push(row[columns.command]);
    found.error.push(row[columns.demand] - row[columns.signal]);
    if (performance.now() > until) {
      say(`${Math.round((100 * i) / rows)} %`);
      await new Promise((next) => setTimeout(next));
      if (own !== turn) return;
      until = performance.now() + SLICE;
    }
  }
  const reached = loop.advance(known.samples - 1);
  if (reached < known.samples - 1) found.lost = reached * known.period;
  found.metrics = known.metrics.map((one) => row[one.column]);
  now = found;
  base = base || found;
  draw();
  judge();
  document.body.dataset.run = own;
  if (Number.isNaN(found.lost)) say(`${text(span)} s, computed in ${text(performance.now() - started, 2)} ms`);
  else say(`diverged at ${text(found.lost)} s`, true);
}
function say(words, lost = false) {
  const place = document.getElementById("state");
  place.textContent = words;
  place.classList.toggle("lost", lost);
}

// Sliders: even in the logarithm where the range has one sign.
const isLog = (one) => one.low * one.high > 0;
function at(one, p) {
  if (p <= 0) return one.low;
  if (p >= 1) return one.high;
  return isLog(one) ? one.low * Math.pow(one.high / one.low, p) : one.low + (one.high - one.low) * p;
}
const place = (one, x) => (isLog(one) ? Math.log(x / one.low) / Math.log(one.high / one.low) : (x - one.low) / (one.high - one.low));
const fields = known.sliders.map((one, i) => {
  const box = made("div", document.getElementById("sliders"), { class: "slider" });
  made("label", box, { for: `slider-${i}` }, one.name);
  made("span", box, { class: "of", id: `of-${i}` }, one.meaning);
  const path = made("code", box, { class: "of" });
  for (const part of one.path.split(/(?<=[._])/)) path.append(part, document.createElement("wbr"));
  const line = made("div", box, { class: "row" });
  const range = made("input", line, { type: "range", id: `slider-${i}`, min: 0, max: 1, step: 0.002, "aria-describedby": `of-${i}` });
  const ends = [read(one, one.low), read(one, one.high)];
  const number = made("input", line, { type: "number", step: "any", "aria-label": `${one.name} [${one.unit || 1}]` });
  made("span", line, { class: "unit of" }, one.unit);
  made("span", box, { class: "of" }, `${text(ends[0])} to ${text(ends[1])} ${one.unit}`);
  const show = () => {
    range.value = place(one, values[i]);
    range.setAttribute("aria-valuetext", withUnit(one, values[i]));
    number.value = Number(read(one, values[i]).toPrecision(6));
  };
  const set = (x) => { values[i] = x; show(); run(); };
  range.addEventListener("input", () => set(at(one, Number(range.value))));
  number.addEventListener("change", () => {
    const x = (Number(number.value) + one.zero) / one.factor;
    if (number.value === "" || !Number.isFinite(x)) show();
    else set(Math.min(Math.max(x, one.low), one.high));
  });
  show();
  return show;
});
document.getElementById("reset").addEventListener("click", () => {
  known.sliders.forEach((one, i) => { values[i] = one.value; fields[i](); });
  run();
});

// Metrics: now, and with the values of the scenario.
const cells = known.metrics.map((one) => {
  const line = made("tr", document.getElementById("metrics"));
  made("th", line, { scope: "row" }, one.unit ? `${one.meaning} [${one.unit}]` : one.meaning);
  return [made("td", line), made("td", line)];
});
function judge() {
  known.metrics.forEach((one, i) => {
    [now, base].forEach((of, j) => { cells[i][j].textContent = text(read(one, of.metrics[i])); });
  });
}

// Plots.
const plots = known.plots.map((one) => {
  const figure = made("figure", document.getElementById("plots"));
  const caption = made("figcaption", figure);
  made("b", caption, {}, one.unit ? `${one.name} [${one.unit}]` : one.name);
  if (one.is.length > 1) for (const name of one.is) made("span", caption, { class: "key", style: `--key: var(${looks[name].colour})` }, looks[name].name);
  made("span", caption, { class: "key", style: "--key: var(--base)" }, "as exported");
  const value = made("span", caption, { class: "of" });
  const canvas = made("canvas", figure, { role: "img" });
  canvas.addEventListener("pointermove", (event) => point((event.offsetX - LEFT) / (canvas.clientWidth - LEFT - RIGHT)));
  canvas.addEventListener("pointerleave", () => point(NaN));
  return { one, canvas, value };
});
const LEFT = 58, RIGHT = 12, TOP = 8, BOTTOM = 24;
function point(share) {
  pointed = share >= 0 && share <= 1 ? share : NaN;
  draw();
}
function ticks(low, high, count) {
  const raw = (high - low) / count, power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].find((k) => k * power >= 0.7 * raw) * power;
  const first = Math.ceil(low / step), found = [];
  for (let k = first; k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}
function draw() {
  for (const plot of plots) drawOne(plot);
}
function drawOne({ one, canvas, value }) {
  if (!now) return;
  const style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue(name);
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  const series = (of) => one.is.map((name) => [name, of[name]]);
  let low = Infinity, high = -Infinity;
  for (const [, data] of [...series(base), ...series(now)]) for (const x of data) {
    const shown = read(one, x);
    if (shown < low) low = shown;
    if (shown > high) high = shown;
  }
  if (!(low <= high)) return;
  const room = 0.06 * (high - low) || Math.abs(high) || 1;
  low -= room; high += room;
  const x = (share) => LEFT + share * (width - LEFT - RIGHT), y = (v) => TOP + ((high - v) / (high - low)) * (height - TOP - BOTTOM);
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = colour("--muted");
  pen.strokeStyle = colour("--grid");
  pen.textAlign = "right"; pen.textBaseline = "middle";
  for (const v of ticks(low, high, Math.max(2, height / 45))) {
    line(pen, [[LEFT, y(v)], [width - RIGHT, y(v)]]);
    pen.fillText(text(v, 5), LEFT - 6, y(v));
  }
  pen.textAlign = "center"; pen.textBaseline = "top";
  for (const t of ticks(0, span, Math.max(2, width / 90))) {
    line(pen, [[x(t / span), TOP], [x(t / span), height - BOTTOM]]);
    const words = t === 0 ? "0" : `${text(t)} s`;
    pen.fillText(words, Math.min(x(t / span), width - pen.measureText(words).width / 2 - 1), height - BOTTOM + 6);
  }
  const curve = ([name, data], key) => {
    pen.strokeStyle = colour(key);
    pen.setLineDash(name === "demand" ? [6, 5] : []);
    line(pen, pixels(data, x, (v) => y(read(one, v)), width));
  };
  pen.lineJoin = "round";
  pen.lineWidth = 1.5;
  if (base !== now) for (const of of series(base)) if (of[0] !== "demand") curve(of, "--base");
  pen.lineWidth = 1.8;
  for (const of of series(now)) curve(of, looks[of[0]].colour);
  pen.setLineDash([]);
  const i = Math.round((pointed * span) / (known.stride * known.period));
  const shown = i < now.command.length;
  value.textContent = shown ? `${text(i * known.stride * known.period)} s: ${series(now).map(([, data]) => text(read(one, data[i]))).join(", ")}` : "";
  pen.strokeStyle = colour("--muted");
  if (shown) line(pen, [[x(pointed), TOP], [x(pointed), height - BOTTOM]]);
  const last = now.command.length - 1;
  canvas.setAttribute("aria-label", `${one.name} over ${text(span)} s, from ${text(low + room)} to ${text(high - room)} ${one.unit}, at the end ${series(now).map(([name, data]) => `${name} ${text(read(one, data[last]))}`).join(", ")}`);
}
function line(pen, points) {
  pen.beginPath();
  for (const [a, b] of points) pen.lineTo(a, b);
  pen.stroke();
}
// The first, smallest, largest and last of each pixel column, so that no peak is lost.
function pixels(data, x, y, width) {
  const share = (i) => (i * known.stride * known.period) / span;
  if (data.length < 2 * width) return data.map((v, i) => [x(share(i)), y(v)]);
  const found = [], per = Math.ceil(data.length / width);
  for (let i = 0; i < data.length; i += per) {
    const part = data.slice(i, i + per);
    for (const v of [part[0], Math.min(...part), Math.max(...part), part[part.length - 1]]) found.push([x(share(i)), y(v)]);
  }
  return found;
}
new ResizeObserver(draw).observe(document.getElementById("plots"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
run();
