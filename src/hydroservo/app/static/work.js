// Work that takes long: how far it is, and a button that ends it.

import { byId } from "./page.js";
import { ask } from "./server.js";

const SOON = 500; // ms after which it is shown

export class Work {
  constructor() {
    this.controllers = new Set();
    byId("stop").addEventListener("click", () => this.stop());
  }

  /** Has the server do a job; what takes long is shown, and can be stopped. */
  async shown(job, request) {
    const controller = new AbortController();
    this.controllers.add(controller);
    const timer = setTimeout(() => this.show("working", null), SOON);
    const began = performance.now();
    try {
      return await ask(job, request, {
        signal: controller.signal,
        progress: (done, what) => performance.now() - began > SOON && this.show(what, done),
      });
    } catch (error) {
      if (error.name === "AbortError") byId("notes").textContent = "Stopped. Change something, and it runs again.";
      throw error;
    } finally {
      clearTimeout(timer);
      this.controllers.delete(controller);
      if (!this.controllers.size) byId("work").hidden = true;
    }
  }

  show(what, done) {
    byId("work").hidden = false;
    byId("work-text").textContent = done === null || done === 0 ? `${what} (a new combination of blocks is compiled first)` : what;
    if (done) byId("work-bar").value = done;
    else byId("work-bar").removeAttribute("value");
  }

  stop() {
    for (const one of this.controllers) one.abort();
    byId("work").hidden = true;
  }
}
