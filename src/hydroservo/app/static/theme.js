// Light, dark, or as the system is.

import { byId, forgetColours } from "./page.js";

const KEY = "hydroservo-theme";
const THEMES = ["system", "light", "dark"];

export function theme(onChange) {
  let chosen = localStorage.getItem(KEY) ?? "system";
  const show = () => {
    document.documentElement.dataset.theme = chosen;
    byId("theme").textContent = `Theme: ${chosen}`;
    forgetColours();
    onChange();
  };
  byId("theme").addEventListener("click", () => {
    chosen = THEMES[(THEMES.indexOf(chosen) + 1) % THEMES.length];
    localStorage.setItem(KEY, chosen);
    show();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  show();
}
