// The machine as a hydraulic circuit with live values; its parts lead to their fields.

import { NONE, byId } from "./page.js";

const SVG = "http://www.w3.org/2000/svg";
const BARREL = { x: 64, y: 40, w: 190, h: 46 };
const SPOOL = 22;

function part(name, attributes, ...children) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const line = (d, more = "pipe") => part("path", { d, class: more });
/** The head of an arrow from one point to another. */
function head(x0, y0, x1, y1) {
  const [dx, dy] = [x1 - x0, y1 - y0].map((one) => (7 * one) / Math.hypot(x1 - x0, y1 - y0));
  return `M${x1 - dx - dy / 2} ${y1 - dy + dx / 2}L${x1} ${y1}L${x1 - dx + dy / 2} ${y1 - dy - dx / 2}`;
}

const text = (x, y, said, more = {}) => part("text", { x, y, ...more }, said);

/** A part that opens its parameters. */
function link(path, label, onPart, ...children) {
  const made = part("g", { role: "button", tabindex: "0", class: "part", "aria-label": `${label}: show its parameters` }, ...children);
  made.addEventListener("click", () => onPart(path));
  made.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    onPart(path);
  });
  return made;
}

export class Circuit {
  constructor(onPart) {
    this.onPart = onPart;
    this.shape = "";
  }

  /** Draws a run's machine. */
  show(run) {
    const shape = JSON.stringify(run.machine);
    this.run = run;
    if (shape === this.shape) return;
    this.shape = shape;
    this.draw(run.machine);
  }

  draw(machine) {
    const svg = part("svg", { viewBox: "0 0 440 316", role: "group", "aria-label": "Hydraulic circuit" });
    svg.append(...this.cylinder(machine), ...(machine.valveless ? this.pump(machine) : [...this.valve(machine), ...this.supply(machine)]),
      ...this.digital(machine));
    byId("drawing").replaceChildren(svg);
  }

  cylinder(machine) {
    const { x, y, w, h } = BARREL;
    this.rodB = line("", "rod");
    this.rodA = line("", "rod");
    this.piston = part("rect", { x: 0, y: y + 2, width: 12, height: h - 4, class: "piston" });
    this.mass = part("g", {}, part("rect", { x: 0, y: y - 8, width: 46, height: h + 16, rx: 3, class: "mass" }),
      text(23, y + h / 2 + 4, "m", { class: "mid" }));
    this.force = text(432, y - 14, "", { class: "value end" });
    this.motion = text(x, y - 14, "", { class: "value" });
    this.a = text(x - 8, y + h + 26, "", { class: "value end" });
    this.b = text(x + w + 10, y + h + 26, "", { class: "value" });
    this.chamberA = part("rect", { x, y, width: 10, height: h, class: "oil" });
    this.chamberB = part("rect", { x, y, width: 10, height: h, class: "oil" });
    this.symmetric = machine.symmetric;
    const body = link("plant", `Cylinder, ${machine.plant}`, this.onPart, this.chamberA, this.chamberB,
      part("rect", { x, y, width: w, height: h, class: "body" }), this.rodA, this.rodB, this.piston, this.mass);
    const load = link("load", `Load, ${machine.load}`, this.onPart, part("rect", { x: 396, y: y - 4, width: 40, height: h + 8, class: "hit" }),
      line(`M432 ${y + h / 2}H402m8 -6l-8 6l8 6`, "arrow"), this.force);
    return [body, load, this.motion, this.a, this.b,
      line(`M${x + 8} ${y + h}V150H122V168`), line(`M${x + w - 8} ${y + h}V150H196V168`)];
  }

  valve(machine) {
    const y = 168;
    const box = (x, ...inside) => part("g", {}, part("rect", { x, y, width: 44, height: 44, class: "body" }), ...inside);
    const arrow = (x0, y0, x1, y1) => line(`M${x0} ${y0}L${x1} ${y1}${head(x0, y0, x1, y1)}`, "flow");
    this.spool = part("g", {},
      box(93, arrow(107, y + 44, 107, y + 1), arrow(123, y, 123, y + 43)),
      box(137, line(`M151 ${y}v12m-6 0h12M167 ${y}v12m-6 0h12M151 ${y + 44}v-12m-6 0h12M167 ${y + 44}v-12m-6 0h12`, "stop")),
      box(181, arrow(195, y + 44, 211, y + 1), arrow(195, y, 211, y + 43)),
      line(`M93 ${y + 10}h-16v24h16M225 ${y + 10}h16v24h-16`, "coil"));
    this.spoolText = text(159, y - 8, "", { class: "value center" });
    return [link("valve", `Valve, ${machine.valve}`, this.onPart, this.spool), this.spoolText,
      line(`M122 168v-4M196 168v-4`), line(`M151 212V242`), line(`M167 212V228H206V242`)];
  }

  supply(machine) {
    this.supplyText = text(84, 268, "", { class: "value end" });
    return [link("supply", `Supply, ${machine.supply}`, this.onPart,
      part("circle", { cx: 151, cy: 264, r: 22, class: "body" }), part("path", { d: "M151 243l-8 13h16z", class: "solid" })),
    line("M151 286v12"), line("M139 292v10h24v-10", "tank"), line("M194 236v10h24v-10", "tank"), this.supplyText];
  }

  pump(machine) {
    this.spoolText = text(228, 200, "", { class: "value" });
    return [line("M122 168V196H136M196 168V196H182"),
      link("drive", `Drive, ${machine.drive}`, this.onPart, part("circle", { cx: 159, cy: 196, r: 23, class: "body" }),
        part("path", { d: "M137 196l11 -7v14zM181 196l-11 -7v14z", class: "solid" }), line("M159 219V240"),
        part("circle", { cx: 159, cy: 260, r: 20, class: "body" }), text(159, 265, "M", { class: "mid" }))];
  }

  digital(machine) {
    this.command = text(330, 222, "", { class: "value" });
    this.demand = text(330, 308, "", { class: "value" });
    const short = (name) => (name.length > 17 ? `${name.slice(0, 16)}…` : name);
    const law = machine.law.at(-1) ?? "";
    return [
      line("M384 86V232", "signal"), line("M318 252H272V190H266", machine.valveless ? "signal hidden" : "signal"),
      ...(machine.valveless ? [line("M318 252H200V260H179", "signal")] : []),
      link("controller", `Law, ${machine.law.join(", ")}`, this.onPart, part("rect", { x: 318, y: 232, width: 118, height: 38, rx: 3, class: "body" }),
        text(377, 256, short(law), { class: "mid" })),
      link("reference", `Demand, ${machine.demand}`, this.onPart, part("rect", { x: 318, y: 278, width: 118, height: 22, class: "hit" }),
        line("M377 290V272m-5 8l5 -8l5 8", "arrow")),
      link("sensors", "Sensors", this.onPart, part("circle", { cx: 384, cy: 150, r: 14, class: "body" }), text(384, 155, "y", { class: "mid" })),
      this.command, this.demand];
  }

  /** Takes the values away. */
  blank() {
    this.run = null;
    for (const one of byId("drawing").querySelectorAll(".value")) one.textContent = "";
  }

  /** The values at a point of the run. */
  at(i) {
    const { run } = this;
    if (!run) return;
    const said = (path, digits = 3) => {
      const one = run.byPath.get(path);
      if (one && !Number.isFinite(one.y[i])) return NONE; // the run was lost before
      return one ? `${Number(one.y[i].toPrecision(digits)).toString().replace("-", "\u2212")} ${one.unit}` : "";
    };
    const raw = (path) => run.byPath.get(path)?.y[i] ?? 0;
    if (Number.isFinite(raw("plant.position"))) this.move(run, raw);
    this.motion.textContent = [said("plant.position"), said("plant.velocity")].filter(Boolean).join("   ");
    this.force.textContent = said("load.force");
    this.a.textContent = said("plant.pressure_a") || said("plant.load_pressure");
    this.b.textContent = said("plant.pressure_b");
    this.spoolText.textContent = said("valve.opening") || said("drive.speed");
    this.command.textContent = said("controller.u");
    this.demand.textContent = said("reference.value");
    if (this.supplyText) this.supplyText.textContent = said("supply.pressure") || run.suppliedText;
  }

  move(run, raw) {
    const { x, y, w, h } = BARREL;
    const [low, high] = run.reach;
    const share = high > low ? Math.min(1, Math.max(0, (raw("plant.position") - low) / (high - low))) : 0.5;
    const at = x + 14 + (w - 40) * (0.1 + 0.8 * share);
    const end = Math.min(x + w + 8 + 0.55 * (at - x), 342);
    this.piston.setAttribute("x", at);
    this.chamberA.setAttribute("width", Math.max(at - x, 0));
    this.chamberB.setAttribute("x", at + 12);
    this.chamberB.setAttribute("width", Math.max(x + w - at - 12, 0));
    this.rodB.setAttribute("d", `M${at + 12} ${y + h / 2}H${end}`);
    this.rodA.setAttribute("d", this.symmetric ? `M${at} ${y + h / 2}H${20 + 0.35 * (at - x)}` : "");
    this.mass.setAttribute("transform", `translate(${end} 0)`);
    const tint = (path) => String(0.12 + 0.75 * Math.min(1, Math.max(0, raw(path) / run.largestPressure)));
    this.chamberA.style.fillOpacity = tint("plant.pressure_a");
    this.chamberB.style.fillOpacity = tint("plant.pressure_b");
    const opening = run.largestOpening ? raw("valve.opening") / run.largestOpening : 0;
    this.spool?.setAttribute("transform", `translate(${SPOOL * Math.max(-1, Math.min(1, opening))} 0)`);
  }
}
