// A log that was dragged in: drawn beside the run, and the machine's numbers from it.

import { byId, colour, element, words } from "./page.js";
import { Plot } from "./plot.js";

const MOST = 8;
const HEIGHT = 130;

/** A log's signals over its own time, each with what the machine that is entered shows under its command. */
export class LogPlots {
  constructor() {
    this.plots = [];
  }

  show(about, [time, ...rows]) {
    this.shown = { about, time, rows };
    this.draw(about.replay, (line) => line.name);
  }

  /** Takes the replay away, for it is of another machine. */
  pending() {
    if (this.shown) this.draw("", (line) => line.name !== "replay");
  }

  redraw() {
    if (this.shown) this.draw(byId("replay").textContent, () => true);
  }

  draw(said, wanted) {
    const { about: { panels, duration }, time, rows } = this.shown;
    byId("replay").textContent = said;
    let i = 0;
    panels.forEach(({ title, unit, lines, extent, clipped }, place) => {
      const plot = (this.plots[place] ??= new Plot(byId("log-plots"), HEIGHT));
      plot.figure.hidden = false;
      const drawn = lines.map((line) => ({ ...line, x: time, y: rows[i++], ...LOOKS[line.name] })).filter(wanted);
      plot.show({ title, unit, across: "s", range: [0, duration], extent, clipped, label: `${title} over ${duration} s: ${drawn.map(({ name }) => name).join(", ")}`,
        lines: drawn.map((line) => ({ ...line, colour: colour(line.ink) })) });
    });
    for (const plot of this.plots.slice(panels.length)) plot.figure.hidden = true;
  }
}

const LOOKS = { log: { ink: "log", width: 1.2 }, replay: { ink: "line-1", width: 1.8 } };

/** Shows a log, and what may be sought in it. */
export function showLog(log, machine, told) {
  const section = byId("log");
  section.hidden = !log;
  if (!log) return;
  const close = element("button", {}, "Put away");
  close.addEventListener("click", () => told.close());
  const remarks = element("ul", {}, ...log.remarks.map((one) => element("li", {}, one)));
  byId("log-about").replaceChildren(signals(log), remarks, sought(machine, told), element("div", { id: "found" }));
  byId("log-heading").replaceChildren(element("h2", {}, `Log ${log.title}`), close);
}

function signals(log) {
  const heads = ["Signal", "Column", "Samples", "Lowest", "Highest", "Unit"];
  const head = element("tr", {}, ...heads.map((one) => element("th", { scope: "col" }, one)));
  const rows = log.signals.map(([name, ...cells]) => element("tr", {},
    element("th", { scope: "row" }, words(name)), ...cells.map((one) => element("td", {}, one))));
  return element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Signals of the log" },
    element("table", {}, element("caption", {}, "How the log is understood"), element("thead", {}, head), element("tbody", {}, ...rows)));
}

function sought(machine, told) {
  const rows = element("div", { class: "sought" });
  const select = element("select", { id: "seek" }, element("option", { value: "" }, "choose…"),
    ...machine().map(({ path }) => element("option", { value: path }, words(path))));
  select.addEventListener("change", () => {
    const number = machine().find(({ path }) => path === select.value);
    select.value = "";
    if (!number || rows.children.length >= MOST || [...rows.querySelectorAll("input")].some((one) => one.dataset.path === number.path)) return;
    rows.append(row(number));
  });
  const find = element("button", { type: "submit" }, "Identify");
  const form = element("form", {}, element("h3", {}, "Numbers of the machine from this log"),
    element("label", { for: "seek" }, "Add a number"), select, rows, find);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    for (const one of rows.querySelectorAll(".problem")) one.hidden = true;
    told.identify(Object.fromEntries([...rows.querySelectorAll("input")].map((one) => [one.dataset.path, one.value])));
  });
  return form;
}

function row(number) {
  const id = `seek-${number.path}`;
  const shown = (factor) => Number((number.value * number.factor * factor).toPrecision(3));
  const [low, high] = number.value > 0 ? [0.5, 2] : [2, 0.5];
  const remove = element("button", { type: "button", "aria-label": `Do not seek ${words(number.path)}` }, "\u00d7");
  const made = element("div", { class: "number" }, element("label", { for: id }, words(number.path)),
    element("input", { id, type: "text", "data-path": number.path, value: `${shown(low)}..${shown(high)} ${number.unit}`.trim(), "aria-describedby": `sought-${number.path}` }),
    remove, element("p", { class: "problem", id: `sought-${number.path}`, hidden: true }));
  remove.addEventListener("click", () => made.remove());
  return made;
}

/** Says what is wrong with a range at its field; says whether it has one. */
export function refuseRange({ path, message }) {
  const place = byId(`sought-${path}`);
  if (!place) return false;
  place.textContent = message;
  place.hidden = false;
  return true;
}

/** Shows what was found. */
export function showFound(found, told) {
  const take = element("button", {}, "Take these numbers");
  take.addEventListener("click", () => told.take(Object.fromEntries(found.parameters.map(({ path, value }) => [path, value]))));
  const rows = found.parameters.map((one) => element("tr", {}, element("th", { scope: "row" }, words(one.path)),
    element("td", {}, one.text), element("td", {}, `${one.low} to ${one.high}`), element("td", {}, one.told ? "yes" : "no")));
  const head = element("tr", {}, ...["Number", "Found", "95 % interval", "Told by the log"].map((one) => element("th", { scope: "col" }, one)));
  byId("found").replaceChildren(
    element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Numbers found" },
      element("table", {}, element("caption", {}, "What the log tells"), element("thead", {}, head), element("tbody", {}, ...rows))),
    element("ul", {}, ...found.remarks.map((one) => element("li", {}, one))), take);
}
