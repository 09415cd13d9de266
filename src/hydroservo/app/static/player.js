// The instant that is shown: by slider, by the pointer over a plot, or as it plays.

import { byId } from "./page.js";

const STEPS = 1000;

export class Player {
  /** @param {(instant: number, i: number) => void} onInstant told the instant [s] and its place in the run */
  constructor(onInstant) {
    this.onInstant = onInstant;
    this.instant = 0;
    this.playing = false;
    byId("instant").addEventListener("input", () => this.to((this.run.duration * byId("instant").value) / STEPS));
    byId("play").addEventListener("click", () => (this.playing ? this.stop() : this.play()));
  }

  show(run) {
    const first = !this.run;
    this.run = run;
    this.to(first ? run.duration / 2 : Math.min(this.instant, run.duration));
  }

  to(instant) {
    if (!this.run) return;
    this.instant = Math.min(Math.max(instant, 0), this.run.duration);
    const { time } = this.run;
    let [low, high] = [0, time.length - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (time[middle] < this.instant) low = middle + 1;
      else high = middle;
    }
    byId("instant").value = String((STEPS * this.instant) / this.run.duration);
    byId("instant").setAttribute("aria-valuetext", `${this.instant.toFixed(3)} s`);
    byId("instant-text").textContent = `t = ${this.instant.toFixed(3)} s`;
    this.onInstant(this.instant, low);
  }

  play() {
    this.playing = true;
    this.button();
    let before = performance.now();
    if (this.instant >= this.run.duration) this.instant = 0;
    const step = (now) => {
      if (!this.playing) return;
      this.to(this.instant + (now - before) / 1000);
      before = now;
      if (this.instant < this.run.duration) requestAnimationFrame(step);
      else this.stop();
    };
    requestAnimationFrame(step);
  }

  stop() {
    this.playing = false;
    this.button();
  }

  button() {
    byId("play").textContent = this.playing ? "Pause" : "Play";
    byId("play").setAttribute("aria-pressed", String(this.playing));
  }
}
