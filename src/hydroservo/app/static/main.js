// The page: what is entered goes to the server, and what comes back is drawn.

import { Circuit } from "./circuit.js";
import { Files } from "./files.js";
import { Follow } from "./follow.js";
import { Form } from "./form.js";
import { byId, options } from "./page.js";
import { Panels } from "./panels.js";
import { showMetrics } from "./metrics.js";
import { Gone, Problem, ask, begin, rowsOf } from "./server.js";
import { State } from "./state.js";
import { readRun, readBode } from "./reading.js";
import { Player } from "./player.js";
import { Work } from "./work.js";
import { theme } from "./theme.js";

const MOST_PINS = 4;
const QUIET = 700; // ms after which a slider rests

const state = new State(() => refresh(true));
const work = new Work();
const circuit = new Circuit((path) => form.reveal(path));
const player = new Player((instant, i) => {
  panels.at(instant);
  circuit.at(i);
});
const panels = new Panels((instant) => player.to(instant));
const form = new Form({
  live: (changes, when) => {
    state.live(changes);
    last = Object.keys(changes)[0];
    runs.ask(when);
    clearTimeout(sliding);
    sliding = setTimeout(rested, QUIET);
    curves.ask(when);
  },
  slid: () => {
    state.commit(undefined, false);
    buttons();
  },
  commit: (changes) => {
    if (changes) last = Object.keys(changes)[0];
    state.commit(changes ? { changes: { ...state.changes, ...changes } } : undefined);
  },
  retype,
});
const files = new Files({ state, work, form, fail, redraw: () => current && draw(current), started: () => state.keep() });

let current = null; // the run that is drawn
let last = ""; // the field that was changed last
let wantsForm = true;
let sliding = 0; // a timer, while a slider moves: what takes longer waits for its end

const runs = new Follow("follow", async () => {
  const withForm = wantsForm;
  wantsForm = false;
  const sketched = sliding && current && !withForm;
  const asked = { ...state.request, signals: state.signals, form: withForm, ...(sketched && { substeps: current.substeps }) };
  const { about, content } = await work.shown("run", asked);
  const run = readRun(about, rowsOf(content, about.points));
  settle();
  if (about.form) form.show(about.form);
  draw(run);
}, fail, () => document.body.classList.add("stale"));


const curves = new Follow("follow-bode", async () => {
  const sketched = Boolean(sliding && panels.now);
  const { about, content } = await ask("frequency", { ...state.request, ...(sketched && { band: panels.band }) });
  byId("bode-problem").hidden = true;
  const drawn = readBode({ ...(sketched && panels.now), ...about, sketched }, rowsOf(content, about.points));
  panels.bode(drawn, state.pins.map(({ bode, title }) => bode && { ...bode, title }).filter(Boolean));
}, (error) => {
  if (error instanceof Gone) return;
  byId("bode-problem").textContent = error.message;
  byId("bode-problem").hidden = false;
  panels.bode(null, []);
});

function draw(run) {
  current = run;
  circuit.show(run);
  panels.runs(run, state.pins, files.log);
  player.show(run);
  showMetrics(run, state.pins, pinning);
  notes(run);
  const signals = run.signals.join();
  if (byId("more").dataset.signals === signals) return;
  byId("more").dataset.signals = signals;
  options(byId("more"), [["", "choose…"], ...run.signals.map((path) => [path, path])], state.signals[0] ?? "");
}

/** Says what a reader should know of the run, a divergence at the field that led to it. */
function notes(run) {
  const lines = [...run.warnings];
  if (run.diverged) {
    const text = `the run is lost at ${run.diverged.at.toPrecision(3)} s: ${run.diverged.by}`;
    lines.unshift(`Diverged: ${text}`);
    if (last) form.problem(last, `with this value ${text}`);
  }
  byId("notes").replaceChildren(...lines.map((line) => Object.assign(document.createElement("p"), { textContent: line })));
  byId("notes").classList.toggle("bad", Boolean(run.diverged));
}

function settle() {
  form.clear();
  byId("problem").hidden = true;
  byId("banner").hidden = true;
  document.body.classList.remove("stale");
}

/** Shows what went wrong where it belongs. */
function fail(error) {
  if (error.name === "AbortError") return;
  if (error instanceof Gone) return away();
  if (!(error instanceof Problem)) throw error;
  wantsForm = true; // the next answer has what this one lacks
  document.body.classList.add("stale");
  const there = form.problem(error.path, error.message);
  byId("problem-text").textContent = [error.path, error.message].filter(Boolean).join(": ");
  byId("problem-field").hidden = !there;
  byId("problem-field").onclick = () => form.reveal(error.path);
  byId("problem").hidden = false;
}

let waiting = false;

/** Waits for a server that is gone; nothing of what was entered is lost. */
async function away() {
  document.body.classList.add("stale");
  byId("banner").textContent = "The server has ended. What you entered is kept here: start hydroservo app again, and the page goes on.";
  byId("banner").hidden = false;
  if (waiting) return;
  waiting = true;
  for (;;) {
    await new Promise((done) => setTimeout(done, 1000));
    try {
      await begin();
      break;
    } catch (error) {
      if (!(error instanceof Gone)) break;
    }
  }
  waiting = false;
  byId("banner").hidden = true;
  refresh(true);
}

function rested() {
  sliding = 0;
  runs.ask(performance.now());
  curves.ask(performance.now());
}

function buttons() {
  byId("undo").disabled = !state.past.length;
  byId("redo").disabled = !state.future.length;
}

/** Asks for everything anew. */
function refresh(withForm) {
  wantsForm ||= withForm;
  buttons();
  byId("scenario").value = state.source.text ? "" : state.source.name;
  runs.ask(performance.now());
  curves.ask(performance.now());
}

async function retype(path, type, given = null) {
  try {
    const { about } = await work.shown("retype", { ...state.request, path, type });
    if (about.missing.length && !given) {
      form.need(path, about.missing, (numbers) => take(path, { ...about.changes, ...numbers }));
      return;
    }
    take(path, about.changes);
    if (about.origin) byId("work-text").textContent = `${type} begins with the numbers of ${about.origin}`;
  } catch (error) {
    refresh(true);
    fail(error);
  }
}

function take(path, changes) {
  last = path;
  form.settled();
  state.commit({ changes });
}

const pinning = {
  remove: (i) => {
    state.pins.splice(i, 1);
    state.keep();
    draw(current);
    curves.ask(performance.now());
  },
  back: (i) => state.commit({ source: state.pins[i].source, changes: state.pins[i].changes }),
};

function pin() {
  if (!current) return;
  const number = 1 + Math.max(0, ...state.pins.map(({ title }) => Number(title.slice(4))));
  state.pins.push({ ...state.snapshot, title: `pin ${number}`, run: current, bode: panels.now });
  state.pins.splice(0, state.pins.length - MOST_PINS);
  state.keep();
  draw(current);
}

/** Runs what was pinned before a reload. */
async function runPins() {
  for (const one of state.pins) {
    const asked = { ...(one.source.text ? { text: one.source.text } : { name: one.source.name }), changes: one.changes };
    const { about, content } = await ask("run", { ...asked, signals: state.signals });
    one.run = readRun(about, rowsOf(content, about.points));
  }
  if (state.pins.length && current) draw(current);
}

function listen() {
  byId("undo").addEventListener("click", () => state.undo());
  byId("redo").addEventListener("click", () => state.redo());
  byId("pin").addEventListener("click", pin);
  byId("scenario").addEventListener("change", () => {
    last = "";
    state.commit({ source: { name: byId("scenario").value }, changes: {} });
  });
  byId("more").addEventListener("change", () => {
    const path = byId("more").value;
    state.signals = path ? [path] : [];
    state.keep();
    refresh(false);
  });
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
    event.preventDefault();
    if (document.activeElement?.matches("input[type=text]")) document.activeElement.blur();
    if (event.shiftKey) state.redo();
    else state.undo();
  });
  theme(() => {
    if (current) draw(current);
    panels.redraw();
  });
}

async function start() {
  listen();
  const about = await begin().catch((error) => (away(), Promise.reject(error)));
  const own = about.scenarios[about.name] ? [] : [[about.name, about.name]];
  options(byId("scenario"), [...own, ...Object.keys(about.scenarios).map((name) => [name, name]), ["", "opened file"]], about.name);
  if (!state.restore()) state.clear({ name: about.name }, about.changes);
  refresh(true);
  runPins().catch(fail);
}

start();
