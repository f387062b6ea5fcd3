// Panels of studies that take longer: exponent with verdict, bifurcation diagram.
class VerdictPanel extends Panel {
  constructor(board) {
    super("Exponent and verdict", board);
    this.study = "exponent";
    this.button = element("button", { type: "button" }, "Compute");
    this.button.addEventListener("click", () => {
      const running = this.button.textContent === "Stop";
      this.told.textContent = running ? "Ends after the present stage." : "Computing ...";
      this.button.textContent = "Stop";
      this.told.classList.remove("refused");
      board.send(running ? { type: "stop" } : { type: "study", kind: this.study });
    });
    this.told = element("p", { class: "hint", role: "status" }, "Largest Lyapunov exponent after 50 periods, over 50 and over 200 periods.");
    this.verdict = element("p", { class: "verdict" });
    this.canvas = element("canvas", { class: "diagram", tabIndex: 0, role: "img", "aria-label": "Exponent over the time, as it settles" });
    this.picks.append(this.button);
    this.canvas.hidden = true;
    this.box.append(this.verdict, this.told, this.canvas);
    this.plot = new Diagram(this.canvas);
  }

  hear(said) {
    if (said.kind !== this.study) {
      return;
    }
    if (said.value !== undefined) {
      const error = Number.isFinite(said.error) ? ` \u00b1 ${shown(said.error, 2)}` : "";
      this.verdict.textContent = `${said.verdict || "no verdict"}: largest exponent ${shown(said.value, 4)}${error} ${said.unit}`;
      this.told.textContent = `${said.periods} of ${said.of} periods. ${said.reason || said.status}`;
      this.canvas.hidden = false;
      this.plot.show([], [{ x: said.time, y: said.history, style: () => colour("series-0"), width: 1.4 }], ["t", "exponent"], ["s", said.unit]);
      this.of = JSON.stringify(this.board.values.now);
    }
    if (said.done) {
      this.idle();
      if (said.fault) {
        this.told.textContent = said.fault;
      }
    }
  }

  idle() {
    this.button.textContent = "Compute";
  }

  update() {
    const stale = this.of && this.of !== JSON.stringify(this.board.values.now);
    this.verdict.style.opacity = stale ? "0.5" : "1";
    if (stale && !this.verdict.textContent.endsWith("(earlier values)")) {
      this.verdict.textContent += " (earlier values)";
    }
  }
}

class DiagramPanel extends Panel {
  constructor(board) {
    super("Bifurcation diagram", board);
    this.study = "diagram";
    const numbers = DATA.knobs.filter((raw) => raw.kind === "number");
    this.parameter = element("select", { "aria-label": "Parameter" }, ...numbers.map((raw) => element("option", { value: raw.name }, raw.name)));
    this.fields = { low: "from", high: "to", count: "values", skip: "skip", keep: "keep" };
    this.inputs = Object.fromEntries(Object.keys(this.fields).map((key) => [key, element("input", { type: "text", inputMode: "decimal" })]));
    Object.assign(this.inputs.count, { value: "60" });
    Object.assign(this.inputs.skip, { value: "50" });
    Object.assign(this.inputs.keep, { value: "40" });
    this.signal = signalChoice("Signal", board, () => this.name, (name) => { this.name = name; });
    this.button = element("button", { type: "button" }, "Paint");
    this.told = element("p", { class: "hint", role: "status" }, "One section point a period at each value; a click on a point opens its run.");
    this.canvas = element("canvas", { class: "diagram square", tabIndex: 0, role: "img", "aria-label": "Bifurcation diagram" });
    this.picks.append(this.parameter, this.signal.select);
    Object.entries(this.fields).forEach(([key, label]) => this.picks.append(element("label", {}, label, this.inputs[key])));
    this.picks.append(this.button);
    this.picks.addEventListener("keydown", (event) => event.stopPropagation());
    this.box.append(this.told, this.canvas);
    this.plot = new Diagram(this.canvas, { onPick: (value) => this.open(value) });
    this.parameter.addEventListener("change", () => this._ends());
    this.button.addEventListener("click", () => this._begin());
    this._ends();
    this.idle();
  }

  _ends() {
    const raw = DATA.knobs.find((one) => one.name === this.parameter.value);
    if (raw) {
      this.scale = scaleOf(raw);
      [this.inputs.low.value, this.inputs.high.value] = [raw.low, raw.high].map((end) => `${fieldText(end, this.scale)} ${prettyUnit(this.scale[1])}`.trim());
    }
  }

  _begin() {
    if (this.button.textContent === "Stop") {
      this.board.send({ type: "stop" });
      return;
    }
    const scales = { low: this.scale, high: this.scale };
    const numbers = Object.fromEntries(Object.entries(this.inputs).map(([key, input]) => [key, typedNumber(input.value, scales[key] || [0, ""])]));
    Object.assign(this, { x: [], y: [], along: this.parameter.value, of: this.name, failed: 0 });
    this.button.textContent = "Stop";
    this.told.textContent = "Computing ...";
    this.told.classList.remove("refused");
    this.board.send({ type: "study", kind: this.study, parameter: this.along, signal: this.name, ...numbers });
  }

  hear(said) {
    if (said.kind !== this.study || !this.x) {
      return; // painted on another page
    }
    if (said.points) {
      said.points.forEach((value) => { this.x.push(said.at); this.y.push(value); });
      this.failed += said.fault ? 1 : 0;
      const lost = this.failed ? `, ${this.failed} failed: ${said.fault || "see the others"}` : "";
      this.told.textContent = `${said.number} of ${said.of} values${lost}`;
      const raw = DATA.knobs.find((one) => one.name === this.along);
      this.plot.show([{ x: this.x, y: this.y, tags: this.x, style: () => colour("series-1") }], [], [this.along, this.of], [raw.unit, this.board.run.unit(this.of)]);
    }
    if (said.done) {
      this.idle();
      this.told.textContent += said.fault ? ` ${said.fault}` : said.stopped ? ", stopped." : "; a click on a point opens its run.";
    }
  }

  open(value) {
    this.board.values.all({ [this.along]: value }, null);
    this.plot.chosen = value;
    this.plot.draw();
  }

  idle() {
    this.button.textContent = "Paint";
  }

  update() {
    const { run } = this.board;
    if (!this.name || !run.known.includes(this.name)) {
      this.name = run.plane[0];
    }
    this.signal.fill(run.known);
  }
}
