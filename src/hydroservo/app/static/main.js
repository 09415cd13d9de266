// The page: what is entered goes to the server, and what comes back is drawn.

import { Circuit } from "./circuit.js";
import { Files } from "./files.js";
import { Follow } from "./follow.js";
import { Form } from "./form.js";
import { NONE, byId, options } from "./page.js";
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
  typed: (same) => (same && !refused ? refresh(false) : outdated()),
  live: (changes, when) => {
    state.live(changes);
    if (refused) [refused, wantsForm] = [false, true];
    last = Object.keys(changes)[0];
    clearTimeout(sliding);
    sliding = setTimeout(rested, QUIET);
    panels.pending();
    files.pending();
    runs.ask(when);
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
  back,
});
const files = new Files({ state, work, form, say, refuse });

let current = null; // the run that is drawn
let last = ""; // the field that was changed last
let wantsForm = true;
let refused = false; // a type or a file was chosen that is not what the server ran
let sliding = 0; // a timer, while a slider moves: what takes longer waits for its end

const runs = new Follow("follow", async () => {
  const [withForm, { version }] = [wantsForm, state];
  wantsForm = false;
  const sketched = Boolean(sliding && current && !withForm);
  const asked = { ...state.request, signals: state.signals, form: withForm, ...(sketched && { substeps: current.substeps }) };
  const answer = await asAsked(version, work.shown("run", asked), sketched);
  if (!answer) {
    wantsForm ||= withForm;
    return;
  }
  const { about, content } = answer;
  const run = readRun(about, rowsOf(content, about.points));
  if (!sketched) state.accept();
  settle();
  if (about.form) form.show(about.form, state.source);
  draw(run);
  if (form.typing) outdated();
}, (error) => refuse(error, form.nearest(error.path ?? "") ? error.path : last), outdated);

const curves = new Follow("follow-bode", async () => {
  const { version } = state;
  const sketched = Boolean(sliding && panels.now);
  const answer = await asAsked(version, ask("frequency", { ...state.request, ...(sketched && { band: panels.band }) }), sketched);
  if (!answer) return;
  const { about, content } = answer;
  byId("bode-problem").hidden = true;
  panels.bode(readBode({ curves: panels.now?.curves, ...about, sketched }, rowsOf(content, about.points)), pinnedBodes());
  if (form.typing) panels.pending();
  buttons();
}, (error) => {
  if (error instanceof Gone) return;
  byId("bode-problem").textContent = [error.path, error.message].filter(Boolean).join(": ");
  byId("bode-problem").hidden = false;
  panels.bode(null, pinnedBodes());
  buttons();
});

/** An answer; none where something else was chosen since, for that is asked for already. */
async function asAsked(version, answer, sketched) {
  const current = () => version === state.version && !refused;
  try {
    const found = await answer;
    return sketched || current() ? found : null;
  } catch (error) {
    if (error instanceof Problem && !current()) return null;
    throw error;
  }
}

const pinnedBodes = () => state.pins.map(({ bode, title }) => bode && { ...bode, title }).filter(Boolean);

function draw(run) {
  if (!current) for (const one of document.querySelectorAll(".before:not(#frequency *)")) one.hidden = false;
  current = run;
  buttons();
  circuit.show(run);
  panels.runs(run, state.pins);
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
  if (run.diverged && last) form.problem(last, `with this value: ${run.diverged}`);
  byId("notes").replaceChildren(...run.warnings.map((line) => Object.assign(document.createElement("p"), { textContent: line })));
  byId("notes").classList.toggle("bad", Boolean(run.diverged));
}

/** Draws anew what is there. */
function redraw() {
  if (!current) return;
  const stale = document.body.classList.contains("stale");
  draw(current);
  if (stale) outdated();
}

function settle() {
  form.clear();
  for (const id of ["problem", "banner"]) byId(id).hidden = true;
  document.body.classList.remove("stale");
}

/** Takes away the numbers of a loop that is no longer the one that is entered; its pictures become grey. */
function outdated() {
  document.body.classList.add("stale");
  const numbers = current?.metrics.map((one) => ({ ...one, text: NONE, value: null }));
  if (current) showMetrics({ ...current, metrics: numbers }, state.pins, pinning);
  byId("notes").replaceChildren();
  form.shut(state.source);
  circuit.blank();
  panels.pending();
  files.pending();
  buttons();
}

/** What is entered was refused. */
function refuse(error, path = error.path) {
  if (error.name === "AbortError") return;
  outdated();
  wantsForm = true; // the next answer has what this one lacks
  say(error, path);
  byId("problem-back").hidden = !state.answered;
}

/** Says what went wrong where it belongs. */
function say(error, path = error.path) {
  if (error.name === "AbortError") return;
  if (error instanceof Gone) return away();
  if (!(error instanceof Problem)) throw error;
  const there = form.problem(path, error.message);
  byId("problem-text").textContent = [error.path, error.message].filter(Boolean).join(": ");
  byId("problem-field").hidden = !there;
  byId("problem-field").onclick = () => form.reveal(path);
  byId("problem-back").hidden = true;
  byId("problem").hidden = false;
}

/** Goes back to what ran last. */
function back() {
  form.forget();
  if (refused || state.valid) refresh(true);
  else state.undo();
}

let waiting = false;

/** Waits for a server that is gone; nothing of what was entered is lost. */
async function away() {
  outdated();
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
  for (const one of [runs, curves, files.replays]) one.ask(performance.now());
}

function buttons() {
  byId("undo").disabled = !state.past.length && !refused;
  byId("redo").disabled = !state.future.length;
  byId("pin").disabled = !current || document.body.classList.contains("stale") || panels.waiting;
}

/** Asks for everything anew. */
function refresh(withForm) {
  wantsForm ||= withForm;
  refused = false;
  outdated();
  byId("scenario").value = state.source.text ? "" : state.source.name;
  for (const one of [runs, curves, files.replays]) one.ask(performance.now());
}

async function retype(path, type, given = null) {
  refused = true;
  outdated();
  try {
    const { about } = await work.shown("retype", { ...state.request, path, type, ...(given && { given }) });
    if (about.missing.length) return form.need(path, about.missing, (numbers) => retype(path, type, numbers));
    last = path;
    form.forget();
    form.begun = about.origin ? { path, text: `${type} begins with the numbers of ${about.origin}.` } : null;
    state.commit({ changes: about.changes });
  } catch (error) {
    refuse(error);
  }
}

const pinning = {
  remove: (i) => {
    state.pins.splice(i, 1);
    state.keep();
    redraw();
    panels.bode(panels.now, pinnedBodes());
  },
  back: (i) => state.commit({ source: state.pins[i].source, changes: state.pins[i].changes }),
};

function pin() {
  if (!current) return;
  const number = 1 + Math.max(0, ...state.pins.map(({ title }) => Number(title.slice(4))));
  state.pins.push({ ...state.snapshot, title: `pin ${number}`, run: current, bode: panels.now });
  state.pins.splice(0, state.pins.length - MOST_PINS);
  state.keep();
  redraw();
}

/** Runs what was pinned before a reload. */
async function runPins() {
  for (const one of state.pins) {
    const asked = { ...(one.source.text ? { text: one.source.text } : { name: one.source.name }), changes: one.changes };
    const { about, content } = await ask("run", { ...asked, signals: state.signals });
    one.run = readRun(about, rowsOf(content, about.points));
  }
  if (state.pins.length) redraw();
}

function undo() {
  if (refused) back();
  else state.undo();
}

function listen() {
  byId("undo").addEventListener("click", undo);
  byId("problem-back").addEventListener("click", back);
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
    else undo();
  });
  theme(() => {
    redraw();
    panels.redraw();
    files.redraw();
  });
}

async function start() {
  listen();
  const about = await begin().catch((error) => (away(), Promise.reject(error)));
  const own = about.scenarios[about.name] ? [] : [[about.name, about.name]];
  options(byId("scenario"), [...own, ...Object.keys(about.scenarios).map((name) => [name, name]), ["", "opened file"]], about.name);
  if (!state.restore()) state.clear({ name: about.name }, about.changes);
  refresh(true);
  runPins().catch(say);
}

start();
