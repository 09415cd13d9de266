// Files of the browser: scenarios opened and saved, exports, logs.

import { Follow } from "./follow.js";
import { LogPlots, refuseRange, showFound, showLog } from "./log.js";
import { byId, download } from "./page.js";
import { Problem, ask, rowsOf, sendLog } from "./server.js";

const LARGEST_TEXT = 2 ** 19; // characters of a scenario
const LARGEST_LOG = 2 ** 26; // bytes

export class Files {
  constructor(page) {
    Object.assign(this, page);
    this.log = null;
    this.plots = new LogPlots();
    this.replays = new Follow("follow-log", () => this.log && this.replay(ask), (error) => this.say(error));
    byId("save").addEventListener("click", () => this.try(() => this.save()));
    byId("export").addEventListener("change", () => this.try(() => this.export()));
    byId("open").addEventListener("change", () => this.try(() => this.taken(byId("open"))));
    byId("log-file").addEventListener("change", () => this.try(() => this.taken(byId("log-file"))));
    this.listenToDrops();
  }

  async try(act) {
    try {
      await act();
    } catch (error) {
      this.say(error);
    }
  }

  async taken(input) {
    const [file] = input.files;
    input.value = "";
    if (file) await this.open(file);
  }

  async open(file) {
    if (file.name.toLowerCase().endsWith(".toml")) await this.openScenario(file);
    else await this.openLog(file);
  }

  listenToDrops() {
    const shown = (on) => (byId("drop").hidden = !on);
    addEventListener("dragover", (event) => {
      event.preventDefault();
      shown(true);
    });
    addEventListener("dragleave", (event) => event.relatedTarget ?? shown(false));
    addEventListener("drop", (event) => {
      event.preventDefault();
      shown(false);
      const [file] = event.dataTransfer.files;
      if (file) this.try(() => this.open(file));
    });
  }

  async openScenario(file) {
    const text = await file.text();
    if (text.length > LARGEST_TEXT) throw new Problem(`${file.name} is larger than a scenario may be`, "");
    try {
      await this.work.shown("form", { text, changes: {} });
    } catch (error) {
      if (error instanceof Problem) return this.refuse(new Problem([error.path, error.message].filter(Boolean).join(": "), file.name));
      throw error;
    }
    this.state.commit({ source: { text, title: file.name }, changes: {} });
  }

  async save() {
    const { about } = await this.work.shown("toml", this.state.request);
    const name = (this.state.source.title ?? this.state.source.name.split("/").pop() ?? "scenario").replace(/\.toml$/, "");
    download(`${name}.toml`, "application/toml", about.text);
  }

  async export() {
    const kind = byId("export").value;
    byId("export").value = "";
    if (!kind) return;
    const { about, content } = await this.work.shown("export", { ...this.state.request, kind });
    download(about.name, about.type, content);
  }

  async openLog(file) {
    if (file.size > LARGEST_LOG) throw new Problem(`${file.name} is larger than ${LARGEST_LOG >> 20} MiB`, "");
    const key = await sendLog(file);
    this.log = { key, title: file.name };
    try {
      const about = await this.replay((...asked) => this.work.shown(...asked));
      showLog({ ...about, title: file.name }, () => this.form.machine(), {
        close: () => this.putAway(),
        identify: (ranges) => this.try(() => this.identify(ranges)),
      });
    } catch (error) {
      this.putAway();
      throw error;
    }
    byId("log").scrollIntoView({ block: "nearest" });
  }

  /** Draws the log with what the machine that is entered shows under its command. */
  async replay(asking) {
    const { version } = this.state;
    const { about, content } = await asking("log", { ...this.state.request, log: this.log.key });
    if (version === this.state.version && this.log) this.plots.show(about, rowsOf(content, about.points));
    return about;
  }

  /** Something was entered that the replay is not of. */
  pending() {
    this.plots.pending();
    if (!this.taking) byId("found")?.replaceChildren();
  }

  redraw() {
    this.plots.redraw();
  }

  putAway() {
    this.log = null;
    showLog(null);
  }

  async identify(ranges) {
    const { about } = await this.work.shown("identify", { ...this.state.request, log: this.log.key, ranges }).catch((error) => {
      if (!(error instanceof Problem) || !refuseRange(error)) throw error;
      return {};
    });
    if (!about) return;
    showFound(about, { take: (changes) => this.take(changes) });
  }

  /** Enters what was found, which stays in sight. */
  take(changes) {
    this.taking = true;
    this.state.commit({ changes: { ...this.state.changes, ...changes } });
    this.taking = false;
  }
}
