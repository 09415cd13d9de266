// The parameters: a group for each block, a row with field and slider for each number.

import { byId, element, words } from "./page.js";

const STEPS = 1000; // of a slider
const SPAN = 5; // a slider goes from a fifth of a number to five times it
const NARROW = 720; // px, on which groups begin closed
const TITLES = {
  controls: "Controlled signal", reference: "Demand", controller: "Law", load: "Load", plant: "Cylinder and mass",
  valve: "Valve", supply: "Supply", drive: "Hydraulics between", sensors: "Sensors", hold: "Output of commands",
  simulation: "Simulation",
};

export class Form {
  /** @param {{typed: Function, live: Function, slid: Function, commit: Function, retype: Function, back: Function}} told what is done with what is entered */
  constructor(told) {
    this.told = told;
    this.shape = "";
    this.rows = new Map();
    this.groups = new Map();
    this.begun = null; // which block has numbers of another scenario, and what is said of it
    byId("find").addEventListener("input", () => this.find());
  }

  /** Shows the blocks and numbers of a scenario; what is open and has the focus stays so. */
  show(blocks, source) {
    this.source = JSON.stringify(source);
    this.shut(source);
    const shape = JSON.stringify(blocks, (key, value) => (["text", "value", "unit", "factor"].includes(key) ? undefined : value));
    if (shape !== this.shape) {
      this.shape = shape;
      this.build(blocks);
    }
    this.fill(blocks);
  }

  /** Keeps the fields shut where they are not those of a scenario. */
  shut(source) {
    byId("fields").inert = JSON.stringify(source) !== this.source;
  }

  build(blocks) {
    const open = new Set([...this.groups].filter(([, one]) => one.open).map(([path]) => path));
    const first = this.groups.size === 0;
    const focused = document.activeElement?.id;
    this.rows.clear();
    this.groups.clear();
    byId("fields").replaceChildren(...blocks.map((block) => this.group(block, (path) => (first ? begins(path) : open.has(path)))));
    this.find();
    if (focused) byId(focused)?.focus();
  }

  group(block, open) {
    const top = !block.path.includes(".");
    const name = block.path.split(".").pop();
    const title = (top && TITLES[block.path]) || words(name);
    const group = element("details", { class: top ? "group top" : "group", open: open(block.path) },
      element("summary", {}, title, " ", element("small", {}, block.type)));
    group.append(element("p", { class: "about" }, block.meaning));
    if (block.types.length > 1) group.append(this.types(block, title));
    group.append(element("p", { class: "problem", id: `problem-${block.path}`, hidden: true }));
    group.append(...block.numbers.map((one) => this.row(one)));
    group.append(...block.blocks.map((one) => this.group(one, open)));
    this.groups.set(block.path, group);
    return group;
  }

  types(block, title) {
    const id = `type-${block.path}`;
    const select = element("select", { id, "aria-describedby": `problem-${block.path}` },
      ...[...new Set([block.type, ...block.types])].map((type) => element("option", { value: type, selected: type === block.type }, type)));
    select.addEventListener("change", () => {
      const own = select.value === select.dataset.type;
      this.groups.get(block.path).classList.toggle("other", !own);
      if (own) this.told.back();
      else this.told.retype(block.path, select.value);
    });
    const needed = element("div", { class: "needed", id: `needed-${block.path}` });
    const begun = this.begun?.path === block.path ? [element("p", { class: "about" }, this.begun.text)] : [];
    return element("div", { class: "type" }, element("label", { for: id }, `Type of ${title.toLowerCase()}`), select, ...begun, needed);
  }

  row(number) {
    const id = `field-${number.path}`;
    const problem = element("p", { class: "problem", id: `problem-${number.path}`, hidden: true });
    const label = element("label", { for: id, title: number.meaning }, words(number.name));
    const field = number.kind === "bool"
      ? element("input", { id, type: "checkbox" })
      : element("input", { id, type: "text", autocomplete: "off", spellcheck: "false" });
    field.setAttribute("aria-describedby", `problem-${number.path} about-${number.path}`);
    const slider = number.kind === "float" ? element("input", {
      type: "range", min: "0", max: String(STEPS), class: "slider", "aria-label": `${words(number.name)}, slider`, id: `slider-${number.path}`,
    }) : null;
    const row = element("div", { class: "number" }, label, field);
    if (slider) row.append(slider);
    row.append(element("p", { class: "about", id: `about-${number.path}`, title: number.meaning }, number.meaning), problem);
    const entry = { row, field, slider, number };
    this.rows.set(number.path, entry);
    this.listen(entry);
    return row;
  }

  listen(entry) {
    const { field, slider } = entry;
    if (field.type === "text") field.addEventListener("input", () => {
      entry.typed = field.value !== entry.number.text;
      this.told.typed(!this.typing);
    });
    field.addEventListener("change", () => {
      entry.typed = false;
      this.told.commit({ [entry.number.path]: valueOf(entry.number, field) });
    });
    if (!slider) return;
    slider.addEventListener("input", (event) => {
      field.value = this.slid(entry);
      slider.setAttribute("aria-valuetext", field.value);
      this.told.live({ [entry.number.path]: field.value }, event.timeStamp);
    });
    slider.addEventListener("change", () => this.told.slid());
  }

  slid({ slider, number, range }) {
    const value = range.at(Number(slider.value) / STEPS);
    const text = String(Number((value * number.factor).toPrecision(4)));
    return number.unit ? `${text} ${number.unit}` : text;
  }

  fill(blocks) {
    for (const block of blocks) {
      for (const number of block.numbers) this.fillRow(number);
      const select = byId(`type-${block.path}`);
      if (select) {
        select.value = block.type;
        select.dataset.type = block.type;
        byId(`needed-${block.path}`).replaceChildren();
        this.groups.get(block.path).classList.remove("other");
      }
      this.fill(block.blocks);
    }
  }

  fillRow(number) {
    const entry = this.rows.get(number.path);
    const { field, slider } = entry;
    entry.number = number;
    if (entry.typed) return;
    if (number.kind === "bool") field.checked = number.text === "True";
    else if (field.value !== number.text) field.value = number.text;
    if (!slider || slider === document.activeElement && entry.range) return;
    entry.range = rangeOf(number);
    slider.hidden = entry.range === null;
    if (!entry.range) return;
    slider.value = String(Math.round(STEPS * entry.range.place(number.value)));
    slider.setAttribute("aria-valuetext", number.text);
  }

  /** Shows what is wrong at its field; says whether there is one. */
  problem(path, text) {
    this.clear();
    const at = this.nearest(path);
    if (!at) return false;
    const asked = byId(`asked-${path}`);
    const place = asked ?? byId(`problem-${at}`);
    place.textContent = asked || at === path.replace(/\.type$/, "") ? text : `${path}: ${text}`;
    place.hidden = false;
    this.open(at);
    (asked ? byId(`needed-${path}`) : this.rows.get(at)?.field)?.setAttribute("aria-invalid", "true");
    byId(`type-${at.replace(/\.type$/, "")}`)?.setAttribute("aria-invalid", "true");
    return true;
  }

  nearest(path) {
    for (let at = path; at; at = at.slice(0, Math.max(0, at.lastIndexOf(".")))) {
      if (byId(`problem-${at}`)) return at;
    }
    return "";
  }

  clear() {
    for (const one of byId("fields").querySelectorAll(".problem")) one.hidden = true;
    for (const one of byId("fields").querySelectorAll("[aria-invalid]")) one.removeAttribute("aria-invalid");
  }

  /** Opens the groups around a block or field. */
  open(at) {
    for (let i = at.length; i > 0; i = at.lastIndexOf(".", i - 1)) {
      const group = this.groups.get(at.slice(0, i));
      if (group) group.open = true;
    }
  }

  /** Opens the groups around a block or field, and goes there. */
  reveal(path) {
    const at = this.nearest(path) || path;
    if (byId("find").value) {
      byId("find").value = "";
      this.find();
    }
    this.open(at);
    const there = this.rows.get(at)?.field ?? byId(`type-${at}`) ?? this.groups.get(at)?.querySelector("summary");
    there?.scrollIntoView({ block: "center", behavior: "auto" });
    there?.focus();
  }

  find() {
    const sought = byId("find").value.trim().toLowerCase();
    for (const { row, number } of this.rows.values()) {
      row.hidden = Boolean(sought) && !`${words(number.path)} ${number.meaning}`.toLowerCase().includes(sought);
    }
    for (const group of this.groups.values()) {
      const some = [...group.querySelectorAll(".number")].some((row) => !row.hidden);
      group.hidden = Boolean(sought) && !some;
      if (sought && some) group.open = true;
    }
  }

  /** Whether something was typed that is not entered yet. */
  get typing() {
    return [...this.rows.values()].some(({ typed }) => typed);
  }

  /** Forgets what was typed and not entered, and numbers that were asked for. */
  forget() {
    for (const entry of this.rows.values()) entry.typed = false;
    for (const one of byId("fields").querySelectorAll(".needed")) one.replaceChildren();
  }

  /** Asks for numbers that a type has no default for. */
  need(path, missing, apply) {
    const place = byId(`needed-${path}`);
    const fields = missing.map((one) => {
      const id = `needed-${one.path}`;
      const hint = one.unit ? `in ${one.unit}` : "a number";
      const field = element("input", { id, type: "text", value: one.text, placeholder: hint, "aria-describedby": `asked-${one.path}` });
      return { number: one, field, row: element("div", { class: "number" }, element("label", { for: id, title: one.meaning }, words(one.name)), field,
        element("p", { class: "about" }, one.meaning), element("p", { class: "problem", id: `asked-${one.path}`, hidden: true })) };
    });
    const back = element("button", { type: "button" }, "Go back");
    back.addEventListener("click", () => this.told.back());
    const form = element("form", {}, element("p", {}, "It has no default for these numbers:"), ...fields.map(({ row }) => row),
      element("button", { type: "submit" }, "Take it"), " ", back);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.clear();
      apply(Object.fromEntries(fields.map(({ number, field }) => [number.path, valueOf(number, field)])));
    });
    place.replaceChildren(form);
    form.querySelector("input").focus();
  }

  /** The numbers that may be sought in a log. */
  machine() {
    const parts = ["plant", "valve", "supply", "drive", "load"];
    return [...this.rows.values()].map(({ number }) => number)
      .filter((one) => one.kind === "float" && one.value && parts.includes(one.path.split(".")[0]));
  }
}

/** Whether a group is open at first: demand and laws, and on a screen with room the cylinder. */
function begins(path) {
  if (innerWidth <= NARROW) return false;
  return path === "reference" || path === "plant" || /^controller(\.controller)*$/.test(path);
}

function valueOf(number, field) {
  if (number.kind === "bool") return field.checked;
  const text = field.value.trim();
  return number.kind === "int" && /^[+-]?\d{1,15}$/.test(text) ? Number(text) : text;
}

/** How a slider's place and a number follow from each other; null where there is no range. */
function rangeOf({ value, low, high }) {
  if (value === null) return null;
  if (value !== 0) {
    const sign = Math.sign(value);
    let [a, b] = [Math.abs(value) / SPAN, Math.abs(value) * SPAN];
    if (sign > 0 && high !== null && b > high) b = high;
    if (sign > 0 && low !== null && a < low) a = low;
    if (!(a < b)) return null;
    return { at: (p) => sign * a * (b / a) ** p, place: (v) => Math.log(Math.abs(v) / a) / Math.log(b / a) };
  }
  if (low === null || high === null || high - low > 1e6) return null;
  return { at: (p) => low + (high - low) * p, place: (v) => (v - low) / (high - low) };
}
