// The metrics of this run beside those of the pinned ones.

import { NONE, byId, element } from "./page.js";

/**
 * @param {object} run this one
 * @param {Array} pins the others
 * @param {{remove: Function, back: Function, rename: Function}} told what is done with a pin
 */
export function showMetrics(run, pins, told) {
  const columns = [{ title: "this run", run }, ...pins];
  const names = [...new Map(columns.flatMap((one) => one.run?.metrics ?? []).map((one) => [one.name, one.meaning]))];
  const head = element("tr", {}, element("th", { scope: "col" }, "Metric"), ...columns.map((one, i) => heading(one, i, told)));
  const rows = names.map(([name, meaning]) => {
    const found = columns.map((one) => one.run?.metrics.find((metric) => metric.name === name));
    const values = found.map((one) => one?.value).filter((one) => typeof one === "number");
    const best = columns.length > 1 && values.length > 1 ? Math.min(...values) : null;
    return element("tr", {}, element("th", { scope: "row", title: meaning }, name.replaceAll("_", " ")),
      ...found.map((one) => cell(one, best)));
  });
  byId("metrics").replaceChildren(element("caption", {}, pins.length ? "The least is bold where less is better." : "Pin a run to compare it with the next."),
    element("thead", {}, head), element("tbody", {}, ...rows));
}

function cell(metric, best) {
  const least = best !== null && metric?.value === best;
  return element("td", {}, least ? element("strong", {}, metric.text) : metric?.text ?? NONE);
}

function heading(column, i, told) {
  const head = element("th", { scope: "col" }, element("span", { class: i ? `pin pin-${((i - 1) % 4) + 1}` : "" }, column.title));
  if (!i) return head;
  const back = element("button", { "aria-label": `Go back to ${column.title}`, title: "Go back to this run's numbers" }, "Go back");
  const remove = element("button", { "aria-label": `Remove ${column.title}`, title: "Remove this run" }, "\u00d7");
  back.addEventListener("click", () => told.back(i - 1));
  remove.addEventListener("click", () => told.remove(i - 1));
  head.append(element("span", { class: "acts" }, back, remove));
  return head;
}
