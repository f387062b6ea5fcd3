// The live page: values go to the server, runs come back.
const PATIENCE = 400; // longest time for which newer values wait for the answer to older ones [ms]
const LONGER = "Still computing. Code for parts that have not run on this machine yet is compiled once, which takes up to a minute.";
const ALONE = "No answer yet. A notebook that was opened again shows its last state: run its cells, and this page answers.";
const AGAIN = 1000; // time between two attempts to connect [ms]

const PANELS = {
  signals: ["Signals over time", (board, names) => new SignalsPanel(board, names)],
  orbit: ["Journal orbit", (board, names) => new OrbitPanel(board, names)],
  phase: ["Phase curve", (board, names) => new PhasePanel(board, names, false)],
  poincare: ["Poincar\u00e9 points", (board, names) => new PhasePanel(board, names, true)],
  spectrum: ["Spectrum", (board, names) => new SpectrumPanel(board, names)],
  peaks: ["Largest values", (board) => new PeaksPanel(board)],
  findings: ["Findings", (board) => new FindingsPanel(board)],
  verdict: ["Exponent and verdict", (board) => new VerdictPanel(board)],
  diagram: ["Bifurcation diagram", (board) => new DiagramPanel(board)],
};
const FIRST_PANELS = ["signals", "orbit", "peaks", "findings"];
const SEVERAL = ["signals", "phase", "spectrum", "poincare"]; // panels that may be there twice

// A run as it came, unpacked.
class LiveRun {
  static async of(raw) {
    const [times, curves, frames, own, points, scene, journals] = await Promise.all([
      columnsOf(raw.signals.abscissae),
      columnsOf(raw.signals.curves),
      columnsOf(raw.signals.time),
      raw.signals.at_frames ? columnsOf(raw.signals.at_frames) : null,
      raw.section ? columnsOf(raw.section.points) : [],
      raw.scene ? Scene.of(raw.scene) : null,
      Promise.all(raw.journals.map(async (one) => ({ raw: one, now: await columnsOf(one.now), path: await columnsOf(one.path) }))),
    ]);
    const { number, main, known, peaks, notes, values } = raw;
    const plane = ["ex", "x"].map((end) => known.find((name) => name.endsWith(`.${end}`) && name.split(".").length === 2)).find(Boolean);
    const beside = plane && [["ex", "ey"], ["x", "vx"]].map(([a, b]) => plane.replace(new RegExp(`\\.${a}$`), `.${b}`)).find((name) => name !== plane && known.includes(name));
    const pair = beside ? [plane, beside] : known.slice(0, 2);
    return Object.assign(new LiveRun(), { raw, number, main, known, peaks, notes, values, plane: pair, times: times[0], curves, frames: frames[0], own, points, scene, journals });
  }

  curve(name) {
    return this.curves[this.raw.signals.names.indexOf(name)];
  }

  atFrame(name, frame) {
    const k = this.raw.signals.names.indexOf(name);
    return k < 0 ? NaN : this.own ? this.own[k][frame] : this.curves[k][this.raw.signals.rows[frame]];
  }

  point(name) {
    return this.raw.section && this.points[this.raw.section.names.indexOf(name)];
  }

  unit(name) {
    return this.raw.units[this.known.indexOf(name)] || "";
  }

  peak(name) {
    const found = this.peaks.find((one) => one[0] === name);
    return found ? found[1] : NaN;
  }
}

class Board {
  constructor() {
    Object.assign(this, { run: null, pins: [], panels: [], clock: null, picture: null, findings: null, waiting: null, sent: 0, expected: 0, newest: -1, frames: 0, asked: [], refusal: "" });
    this.stats = { ticks: 0 };
    this.values = new Values((values, length, typed) => this.change(values, length, typed));
    this._panels();
    this._keep();
    this._connect();
    document.getElementById("panels").addEventListener("keydown", (event) => {
      if (["INPUT", "CANVAS"].includes(event.target.tagName)) {
        event.stopPropagation();
      }
    });
  }

  // Connection

  _connect() {
    if (DATA.held) { // in a notebook: through the frame around this page
      document.documentElement.dataset.held = "";
      window.addEventListener("message", (event) => event.source === parent && this._hear(JSON.parse(event.data)));
      this.send({ type: "open" });
      this.want();
      return;
    }
    this.socket = new WebSocket(`ws://${location.host}/ws?token=${encodeURIComponent(DATA.token)}`);
    this.socket.addEventListener("open", () => {
      this.state("busy", "running");
      this.newest = -1; // of a program that was started anew
      this._fromLink();
      this.want();
    });
    this.socket.addEventListener("message", (event) => this._hear(JSON.parse(event.data)));
    this.socket.addEventListener("close", (event) => {
      this.state("error", "not connected");
      this.fault(event.reason || "The connection to flexmb is lost; the page tries again. Is the program still running? What is shown stays.");
      this.sent = 0;
      setTimeout(() => this._connect(), AGAIN);
    });
  }

  send(message) {
    if (message.type !== "want") {
      this.refusal = ""; // what was refused is told until the next wish
    }
    if (DATA.held) {
      parent.postMessage(message, "*");
    } else if (this.socket.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify(message));
    }
  }

  // New values: sent at once, or after the answer to the ones before; a typed text alone, so that its refusal is that of its field.
  change(values, length, typed = false) {
    if (typed && this.waiting) {
      this._post();
    }
    const { values: earlier = {}, length: before = null } = this.waiting || {};
    this.waiting = { values: { ...earlier, ...values }, length: length === null ? before : length };
    this.state("busy", "running");
    this[typed ? "_post" : "_flush"]();
  }

  _flush() {
    if (!this.waiting || (this.sent && performance.now() - this.sent < PATIENCE)) {
      clearTimeout(this.later);
      this.later = this.waiting ? setTimeout(() => this._flush(), PATIENCE) : null;
      return;
    }
    this._post();
  }

  _post() {
    const { values, length } = this.waiting;
    this.waiting = null;
    this.expected = Math.max(this.newest, this.sent ? this.expected : this.newest) + 1; // number of the answer
    this.sent = performance.now();
    this.send({ type: "set", values, ...(length === null ? {} : { length }) });
    this.remember();
  }

  _hear(said) {
    if (said.type === "run") {
      this.arrived = (this.arrived || Promise.resolve()).then(() => this._show(said)).catch((error) => this.fault(String(error)));
    } else if (said.type === "findings") {
      this.findings = said;
      this.panels.filter((one) => one.kind === "findings").forEach((one) => one.panel.update());
    } else if (said.type === "study") {
      this.panels.forEach(({ panel }) => panel.hear(said));
    } else if (said.type === "saved") {
      document.getElementById("copied").textContent = said.text;
    } else if (said.type === "refused") {
      this.sent = 0;
      this.state("error", "refused");
      const beside = this.panels.map(({ panel }) => panel.refuse(said.field, said.text)).some(Boolean);
      if (!beside && !this.values.refuse(said.field, said.text)) {
        this.refusal = said.text;
        this.fault(said.text);
      }
    }
  }

  state(kind, text) {
    const badge = document.getElementById("state");
    badge.className = `badge ${kind}`;
    badge.textContent = text;
    clearTimeout(this.wondering);
    if (kind === "busy") {
      this.wondering = setTimeout(() => { document.getElementById("told").textContent = DATA.held ? ALONE : LONGER; }, PATIENCE * 4);
    }
  }

  fault(text) {
    const box = document.getElementById("fault");
    box.textContent = text;
    box.hidden = !text;
  }

  // Runs

  async _show(said) {
    if (said.number < this.newest) {
      return; // an answer to a wish for signals that a newer run has overtaken
    }
    if (said.done && said.number >= this.expected) {
      this.sent = 0;
    }
    this.newest = said.number;
    if (!this.waiting && !this.sent) {
      this.values.show(said.values, said.length, true);
    }
    document.getElementById("code").textContent = said.code;
    document.getElementById("copy-command").disabled = !said.command;
    this.texts = { code: said.code, command: said.command };
    const bad = said.done && !said.ok;
    this.state(bad ? "error" : said.done ? "good" : "busy", bad ? "not finished" : said.done ? "finished" : "running");
    this.fault(bad ? said.status : this.refusal);
    const seconds = said.seconds ? ` Computed in ${shown(said.seconds, 2)} s.` : "";
    document.getElementById("told").textContent = bad ? "" : said.status + seconds;
    ["save-report", "save-film", "save-netcdf"].forEach((id) => document.getElementById(id).setAttribute("aria-disabled", String(!said.signals)));
    if (said.signals) {
      this.run = await LiveRun.of(said);
      const first = !this.clock;
      this._move();
      this.panels.forEach(({ panel }) => panel.update());
      this._complete();
      if (first && this.clock && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
        this.clock.play(true);
      }
      this.remember();
    }
    this.frames += 1;
    document.documentElement.dataset.ready = "live";
    this._flush();
  }

  // The newest run in the place of the one before; the time keeps its frame, the picture its view.
  _move() {
    const { run } = this;
    if (!run.scene) {
      return;
    }
    const canvas = document.getElementById("picture");
    if (!this.picture) {
      this.picture = new Picture(canvas, run.scene);
      this.clock = new Clock(run.frames, this.stats);
      this.controls = new Controls(this.clock, this.picture);
      this.clock.onChange(() => this.panels.forEach(({ panel }) => panel.move()));
      this._flexible(run);
      return;
    }
    const { clock, picture } = this;
    const fresh = new Picture(canvas, run.scene);
    const same = fresh.scene.raw.nodes.length === picture.scene.raw.nodes.length && fresh.size < 1.3 * picture.size && picture.size < 1.3 * fresh.size;
    const { scene, limits, small, markers } = fresh;
    Object.assign(picture, { scene, limits, small, markers, placeOf: {} });
    if (!same) {
      Object.assign(picture, { box: fresh.box, size: fresh.size, traces: [] });
      picture.fit();
      this._flexible(run);
    }
    this.controls._magnify(document.getElementById("magnification").value);
    clock.times = run.frames;
    clock.frame = Math.min(clock.frame, clock.last);
    clock.time = clock.times[clock.frame];
    this.controls.slider.max = String(clock.last);
    this.controls.show();
    this.controls._legend();
  }

  // Choices of flexible parts, where there are some.
  _flexible(run) {
    const { fields } = run.raw;
    const colours = document.getElementById("colour");
    const flexible = run.raw.scene.beams.length + run.raw.scene.meshes.length > 0;
    [colours, document.getElementById("magnification")].forEach((choice) => { choice.closest("label").hidden = !flexible; });
    [...colours.options].forEach((option) => { option.disabled = option.value !== "part" && !fields.includes(option.value); });
    const wished = fields.includes(colours.value) ? colours.value : fields[0] || "part";
    colours.value = wished;
    this.picture.look.colour = wished;
    this.controls.redraw();
  }

  // Panels

  _panels() {
    const add = document.getElementById("add-panel");
    Object.entries(PANELS).forEach(([kind, [title]]) => add.append(element("option", { value: kind }, title)));
    add.addEventListener("change", () => {
      if (add.value) {
        const made = this.addPanel(add.value, []);
        add.value = "";
        this.want();
        made.box.scrollIntoView({ block: "nearest" });
      }
    });
    const wished = new URLSearchParams(location.hash.slice(1)).get("_panels");
    const listed = wished ? wished.split(";").map((one) => one.split(":")) : FIRST_PANELS.map((kind) => [kind, ""]);
    listed.filter(([kind]) => kind in PANELS).slice(0, 12).forEach(([kind, names]) => this.addPanel(kind, names ? names.split(",") : []));
  }

  addPanel(kind, names) {
    const there = this.panels.find((one) => one.kind === kind);
    if (there && !SEVERAL.includes(kind)) {
      return there.panel;
    }
    const panel = PANELS[kind][1](this, names);
    const entry = { kind, panel };
    this.panels.push(entry);
    document.getElementById("panels").append(panel.box);
    panel.close.addEventListener("click", () => {
      panel.box.remove();
      this.panels = this.panels.filter((one) => one !== entry);
      this.remember();
    });
    if (this.run) {
      panel.update();
      this._complete();
    }
    return panel;
  }

  // Ask for the signals of all panels.
  want() {
    this.asked = [...new Set(this.panels.flatMap(({ panel }) => panel.wanted).filter(Boolean))];
    this.send({ type: "want", signals: this.asked });
    this.remember();
  }

  // Ask for signals that a panel has chosen by itself.
  _complete() {
    const missing = (name) => this.run.known.includes(name) && !this.run.raw.signals.names.includes(name) && !this.asked.includes(name);
    if (this.panels.some(({ panel }) => panel.wanted.some(missing))) {
      this.want();
    }
  }

  // Pins, texts, link

  _keep() {
    document.getElementById("pin").addEventListener("click", () => {
      if (this.run) {
        if (this.pins.length === MOST_PINS) {
          document.getElementById("copied").textContent = `${MOST_PINS} pins at most: the oldest one made room.`;
        }
        this.pins = [...this.pins, this.run].slice(-MOST_PINS);
        this._showPins();
      }
    });
    document.getElementById("go-on").addEventListener("change", (event) => this.send({ type: "go", on: event.target.checked }));
    document.getElementById("copy-code").addEventListener("click", () => this._copy(this.texts.code, "Python text"));
    document.getElementById("copy-command").addEventListener("click", () => this._copy(this.texts.command, "command"));
    document.getElementById("copy-link").addEventListener("click", () => this._copy(location.href, "link without the token"));
    const query = `?token=${encodeURIComponent(DATA.token)}`;
    const saves = { "save-report": "report.html", "save-film": "film", "save-netcdf": "run.nc" };
    Object.entries(saves).forEach(([id, file]) => {
      const link = document.getElementById(id);
      link.href = DATA.held ? "#keep" : `/${file}${query}`;
      link.addEventListener("click", (event) => {
        const drawn = id === "save-film" ? "The film is drawn, which takes some seconds" : "The file is written";
        document.getElementById("copied").textContent = `${drawn}; ${DATA.held ? "the notebook's kernel" : "the browser"} saves it then.`;
        if (DATA.held) { // in a notebook the kernel writes
          event.preventDefault();
          this.send({ type: "save", file });
        }
      });
    });
    document.querySelectorAll("[data-served]").forEach((one) => { one.hidden = Boolean(DATA.held); });
  }

  async _copy(text, what) {
    const said = document.getElementById("copied");
    try {
      await navigator.clipboard.writeText(text);
      said.textContent = `Copied, ${what}: ${text}`;
    } catch {
      said.textContent = text;
    }
  }

  _showPins() {
    document.getElementById("pins").replaceChildren(...this.pins.map((run, k) => {
      const remove = element("button", { type: "button", class: "close", "aria-label": `Remove pin ${k + 1}` }, "\u00d7");
      remove.addEventListener("click", () => {
        this.pins = this.pins.filter((one) => one !== run);
        this._showPins();
      });
      const differs = Object.entries(run.values).map(([name, value]) => `${name} ${this.values.knobs.get(name).told(value)}`);
      const back = element("button", { type: "button" }, "Go there");
      back.addEventListener("click", () => this.values.all(run.values, run.raw.length));
      const dash = element("span", { class: "dash" });
      return element("li", {}, dash, element("span", {}, `pin ${k + 1}: ${differs.join(", ")}`), back, remove);
    }));
    if (this.run) {
      this.panels.forEach(({ panel }) => panel.update());
    }
  }

  // All settings in the address, which loses its token.
  remember() {
    const settings = new URLSearchParams();
    Object.entries(this.values.now).forEach(([name, value]) => settings.set(name, JSON.stringify(value)));
    settings.set("_length", JSON.stringify(this.values.length.value));
    settings.set("_panels", this.panels.map(({ kind, panel }) => (panel.state() ? `${kind}:${panel.state()}` : kind)).join(";"));
    clearTimeout(this.remembering);
    if (DATA.held) {
      return; // a frame has no address
    }
    this.remembering = setTimeout(() => history.replaceState(null, "", `/#${settings}`), 150);
  }

  // Values of a link that was opened.
  _fromLink() {
    if (this.linked) {
      return;
    }
    this.linked = true;
    const settings = [...new URLSearchParams(location.hash.slice(1))].filter(([name]) => name !== "_panels");
    const read = ([name, text]) => {
      try {
        return [[name, JSON.parse(text)]];
      } catch {
        return [[name, text]]; // is refused, and told
      }
    };
    const { _length: length = null, ...values } = Object.fromEntries(settings.flatMap(read));
    if (settings.length) {
      this.values.all(values, length);
    }
  }
}

window.flexmbLive = new Board();
