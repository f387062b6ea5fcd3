// Panels beside the mechanism; each shows the newest run and, dashed, the pinned ones.
const DASHES = [[7, 4], [2, 3], [9, 3, 2, 3]];
const MOST_PINS = 3;

// A panel with the names of its signals, which go into the link; `update` after a run, `move` with the time.
class Panel {
  constructor(title, board, names = []) {
    const box = element("section", { class: "live-panel" });
    const close = element("button", { type: "button", class: "close", "aria-label": `Remove the panel ${title}` }, "\u00d7");
    const picks = element("div", { class: "picks" });
    box.append(element("div", { class: "panel-title" }, element("h2", {}, title), close), picks);
    Object.assign(this, { board, names, box, close, picks });
  }

  // Signals that its messages need.
  get wanted() {
    return this.names;
  }

  state() {
    return this.names.join(",");
  }

  move() {}

  hear() {} // of a study

  // Tell a refusal of this study; false where it belongs elsewhere.
  refuse(study, text) {
    if (!study || study !== this.study) {
      return false;
    }
    this.idle();
    this.told.textContent = text.replace(/^explore: /, "");
    this.told.classList.add("refused");
    return true;
  }
}

// Choice of a signal, which asks for signals that are not here yet.
function signalChoice(label, board, chosen, changed) {
  const select = element("select", { "aria-label": label });
  const fill = (names) => {
    if (select.options.length !== names.length || (names.length && select.options[0].value !== names[0])) {
      select.replaceChildren(...names.map((name) => element("option", { value: name }, name)));
    }
    select.value = chosen();
  };
  select.addEventListener("change", () => changed(select.value));
  return { select, fill };
}

class PlotPanel extends Panel {
  constructor(title, board, names, { square = false } = {}) {
    super(title, board, names);
    this.canvas = element("canvas", { class: square ? "diagram square" : "diagram", tabIndex: 0, role: "img", "aria-label": title });
    this.box.append(this.canvas);
    this.plot = new Diagram(this.canvas);
  }

  // Runs to be drawn: the newest one solid, pinned ones dashed.
  get runs() {
    const pins = this.board.pins.map((run, k) => ({ run, dash: DASHES[k % DASHES.length] }));
    return [...pins, { run: this.board.run, dash: undefined }].filter((one) => one.run);
  }
}

// Signals over time.
class SignalsPanel extends PlotPanel {
  constructor(board, names) {
    super("Signals over time", board, names);
    this.chips = element("span", { class: "picks" });
    this.add = signalChoice("Add a signal", board, () => "", (name) => {
      if (name && !this.names.includes(name)) {
        this.names.push(name);
        board.want();
        this.update();
      }
    });
    this.picks.append(this.chips, this.add.select);
    let from = null;
    this.canvas.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (from && Math.hypot(event.clientX - from[0], event.clientY - from[1]) <= 4 && board.clock) {
        board.clock.goTo(this.plot.world(event.clientX - this.canvas.getBoundingClientRect().left, 0)[0]);
      }
    });
  }

  update() {
    const { run } = this.board;
    if (!this.names.length) {
      this.names = run.main.slice(0, 1);
    }
    this.add.fill(["", ...run.known]);
    this.add.select.options[0].textContent = "Add a signal ...";
    this.readouts = this.names.map(() => element("output"));
    this.chips.replaceChildren(...this.names.map((name, k) => {
      const remove = element("button", { type: "button", "aria-label": `Remove ${name}` }, "\u00d7");
      remove.addEventListener("click", () => {
        this.names = this.names.filter((one) => one !== name);
        this.update();
        this.board.remember();
      });
      return element("span", { class: "chip" }, element("span", { class: `key key-${seriesNumber(k)}` }), `${name} `, this.readouts[k], remove);
    }));
    const lines = this.runs.flatMap(({ run: one, dash }) => this.names.map((name, k) => {
      const y = one.curve(name);
      return y && { x: one.times, y, style: () => seriesColour(k), width: dash ? 1 : 1.4, dash };
    })).filter(Boolean);
    const units = [...new Set(this.names.map((name) => run.unit(name)))];
    this.plot.show([], lines, ["t", this.names.length === 1 ? this.names[0] : ""], ["s", units.length === 1 ? units[0] : ""]);
    this.move();
  }

  move() {
    const { clock, run } = this.board;
    if (clock && run) {
      this.plot.chosen = clock.times[clock.frame];
      this.plot.draw();
      this.names.forEach((name, k) => {
        const value = run.atFrame(name, clock.frame);
        const [power, unit] = prefixed(run.unit(name), Math.abs(value));
        this.readouts[k].textContent = Number.isFinite(value) ? `${shown(value / 10 ** power, 4)} ${prettyUnit(unit)}` : "";
      });
    }
  }
}

// Two signals over one another: the whole curve, or its points once a period.
class PhasePanel extends PlotPanel {
  constructor(board, names, points) {
    super(points ? "Poincar\u00e9 points" : "Phase curve", board, names, { square: true });
    this.points = points;
    this.choices = ["Abscissa", "Ordinate"].map((label, k) => signalChoice(label, board, () => this.names[k], (name) => {
      this.names[k] = name;
      board.want();
      this.update();
    }));
    this.picks.append(...this.choices.map((choice) => choice.select));
    this.count = element("span", { class: "hint" });
    this.picks.append(this.count);
  }

  update() {
    const { run } = this.board;
    if (this.names.length < 2 || !this.names.every((name) => run.known.includes(name))) {
      this.names = run.plane;
    }
    this.choices.forEach((choice) => choice.fill(run.known));
    const [a, b] = this.names;
    this.plot.equal = run.unit(a) === run.unit(b) && run.unit(a) === "m";
    const dotted = [];
    const lines = [];
    this.runs.forEach(({ run: one, dash }) => {
      const [x, y] = [a, b].map((name) => (this.points ? one.point(name) : one.curve(name)));
      if (x && y && this.points) {
        dotted.push({ x, y, style: () => colour(dash ? "faint" : "series-1"), under: Boolean(dash) });
      } else if (x && y) {
        lines.push({ x, y, style: () => colour(dash ? "muted" : "series-0"), width: dash ? 0.9 : 1.2, dash });
      }
    });
    const newest = dotted.length ? dotted[dotted.length - 1].x.length : 0;
    this.count.textContent = this.points ? `${newest} points, one a period` : "";
    this.base = [dotted, lines];
    this.plot.show(dotted, lines, this.names, this.names.map((name) => run.unit(name)));
    this.move();
  }

  move() {
    const { clock, run } = this.board;
    if (!this.points && clock && run) {
      const [x, y] = this.names.map((name) => run.atFrame(name, clock.frame));
      this.plot.groups = [...this.base[0], { x: [x], y: [y], style: () => colour("alert") }];
      this.plot.draw();
    }
  }
}

// Amplitudes of a signal over the frequency, by a Hann window and a fast Fourier transform.
class SpectrumPanel extends PlotPanel {
  constructor(board, names) {
    super("Spectrum", board, names);
    this.choice = signalChoice("Signal of the spectrum", board, () => this.names[0], (name) => {
      this.names = [name];
      board.want();
      this.update();
    });
    this.picks.append(this.choice.select);
    this.told = element("span", { class: "hint" });
    this.picks.append(this.told);
  }

  update() {
    const { run } = this.board;
    if (!this.names.length || !run.known.includes(this.names[0])) {
      this.names = run.main.slice(0, 1);
    }
    this.choice.fill(run.known);
    const lines = this.runs.map(({ run: one, dash }) => {
      const y = one.curve(this.names[0]);
      return y && y.length > 3 && { ...amplitudes(one.times, y), style: () => colour(dash ? "muted" : "series-0"), width: dash ? 0.9 : 1.3, dash };
    }).filter(Boolean);
    const odd = lines.some((line) => !line.even);
    this.told.textContent = odd ? "Instants are not evenly spaced: values between them by straight lines lower high frequencies." : "";
    this.plot.show([], lines, ["frequency", `log10 |${this.names[0]}|`], ["Hz", run.unit(this.names[0])]);
  }
}

// Frequencies [Hz] below that of Nyquist and decimal logarithms of amplitudes of a curve, by its samples but the last one,
// where a period begins anew or a run ended between two instants. Samples at odd times are read off at even ones.
function amplitudes(times, curve) {
  const n = curve.length - 1;
  const [t0, step] = [times[0], (times[n - 1] - times[0]) / (n - 1)];
  const even = times.every((t, k) => k === n || Math.abs(t - t0 - k * step) <= 0.01 * step);
  const samples = even ? Float64Array.from(curve).subarray(0, n) : readOff(times, curve, n);
  const mean = samples.reduce((sum, value) => sum + value, 0) / n;
  const window = (k) => 1 - Math.cos((2 * Math.PI * k) / n); // twice Hann's
  const sizes = transformed(samples.map((value, k) => (value - mean) * window(k))).map((size) => (2 / n) * size);
  const floor = 1e-8 * Math.max(...sizes) || 1e-300;
  const span = even ? n * step : times[n] - t0;
  return { x: sizes.map((_, k) => (k + 1) / span), y: sizes.map((size) => Math.log10(Math.max(size, floor))), even };
}

// A curve at n even times by straight lines, which lower high frequencies.
function readOff(times, curve, n) {
  let place = 0;
  return Float64Array.from({ length: n }, (_, k) => {
    const t = times[0] + ((times[n] - times[0]) * k) / n;
    while (place + 2 < times.length && times[place + 1] < t) {
      place += 1;
    }
    const span = times[place + 1] - times[place];
    const share = span > 0 ? (t - times[place]) / span : 0;
    return curve[place] + share * (curve[place + 1] - curve[place]);
  });
}

// Absolute values of the Fourier transform of n real numbers, of the lines k with 0 < k < n / 2. With 2 j k = j^2 + k^2 -
// (k - j)^2 it is a convolution (L. I. Bluestein, IEEE Trans. Audio Electroacoustics 18 (1970) 451).
function transformed(values) {
  const n = values.length;
  const m = 2 ** Math.ceil(Math.log2(2 * n));
  const [re, im, chirp, other] = [0, 0, 0, 0].map(() => new Float64Array(m));
  for (let k = 0; k < n; k += 1) {
    const angle = (Math.PI * ((k * k) % (2 * n))) / n;
    [re[k], im[k]] = [values[k] * Math.cos(angle), -values[k] * Math.sin(angle)];
    chirp[k] = chirp[(m - k) % m] = Math.cos(angle);
    other[k] = other[(m - k) % m] = Math.sin(angle);
  }
  transform(re, im);
  transform(chirp, other);
  for (let k = 0; k < m; k += 1) { // conjugates: the way back is the same transform
    [re[k], im[k]] = [re[k] * chirp[k] - im[k] * other[k], -re[k] * other[k] - im[k] * chirp[k]];
  }
  transform(re, im);
  return Float64Array.from({ length: Math.max(0, Math.ceil(n / 2) - 1) }, (_, k) => Math.hypot(re[k + 1], im[k + 1]) / m);
}

// Fourier transform in place, of 2^m complex numbers.
function transform(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i += 1) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) {
      j ^= bit;
    }
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let size = 2; size <= n; size *= 2) {
    const angle = (-2 * Math.PI) / size;
    for (let start = 0; start < n; start += size) {
      for (let k = 0; k < size / 2; k += 1) {
        const [c, s] = [Math.cos(angle * k), Math.sin(angle * k)];
        const [a, b] = [start + k, start + k + size / 2];
        const [x, y] = [c * re[b] - s * im[b], c * im[b] + s * re[b]];
        [re[b], im[b], re[a], im[a]] = [re[a] - x, im[a] - y, re[a] + x, im[a] + y];
      }
    }
  }
}

// Journal in its bearing, with the clearance circle.
class OrbitPanel extends Panel {
  constructor(board, names) {
    super("Journal orbit", board);
    this.joint = names[0] || "";
    this.select = element("select", { "aria-label": "Joint" });
    this.select.addEventListener("change", () => {
      this.joint = this.select.value;
      this.update();
      board.remember();
    });
    this.picks.append(this.select);
    this.canvas = element("canvas", { class: "journal", role: "img", "aria-label": "Journal in its bearing, with the path of its centre and the clearance circle" });
    this.none = element("p", { class: "hint" }, "This mechanism has no joint with clearance at the present values.");
    this.box.append(this.canvas, this.none);
    this.journal = null;
    onTheme(() => this.move());
    new ResizeObserver(() => this.move()).observe(this.canvas);
  }

  state() {
    return this.joint;
  }

  update() {
    const found = this.board.run.journals;
    const joints = found.map((one) => one.raw.joint);
    if (!joints.includes(this.joint)) {
      this.joint = joints[0] || "";
    }
    this.select.replaceChildren(...joints.map((joint) => element("option", { value: joint }, joint)));
    this.select.value = this.joint;
    const one = found.find((entry) => entry.raw.joint === this.joint);
    [this.canvas.hidden, this.select.hidden, this.none.hidden] = [!one, joints.length < 2, Boolean(one)];
    if (one && !this.journal) {
      this.journal = new Journal(one.raw, this.canvas, one.now, one.path);
    } else if (one) {
      Object.assign(this.journal, one, { largest: largeValue([one.now[3]], 0.98) });
    }
    if (this.journal) {
      this.journal.readout.hidden = !one;
    }
    this.move();
  }

  move() {
    if (this.journal && this.board.clock && !this.canvas.hidden) {
      this.journal.draw(this.board.clock.frame);
      this._pinned();
    }
  }

  // Paths of pinned runs, in the clearance of the newest one.
  _pinned() {
    const { context, width, height } = fitted(this.canvas);
    const unit = (0.38 * Math.min(width, height)) / 2 / this.journal.raw.clearance;
    this.board.pins.forEach((run, k) => {
      const one = run.journals.find((entry) => entry.raw.joint === this.joint);
      if (one) {
        context.strokeStyle = colour("muted");
        context.lineWidth = 0.7;
        context.setLineDash(DASHES[k % DASHES.length]);
        context.beginPath();
        one.path[0].forEach((ex, i) => context.lineTo(width / 2 + ex * unit, height / 2 - one.path[1][i] * unit));
        context.stroke();
        context.setLineDash([]);
      }
    });
  }
}

// Largest values of the newest and the pinned runs.
class PeaksPanel extends Panel {
  constructor(board) {
    super("Largest values", board);
    this.host = element("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": "Largest values" });
    this.box.append(this.host);
  }

  update() {
    const { run, pins } = this.board;
    const heads = ["signal", "now", ...pins.map((_, k) => `pin ${k + 1}`), "unit", "at t [s]"];
    const head = element("tr", {}, ...heads.map((text, k) => element("th", { scope: "col", class: k && text !== "unit" ? "number" : "" }, text)));
    const rows = run.peaks.map(([name, value, time, unit]) => {
      const others = pins.map((pin) => pin.peak(name));
      const cells = [value, ...others].map((one) => element("td", { class: "number" }, shown(one, 5)));
      const go = element("button", { type: "button", class: "go" }, shown(time, 6));
      go.addEventListener("click", () => this.board.clock.goTo(time));
      return element("tr", {}, element("th", { scope: "row" }, name), ...cells, element("td", {}, prettyUnit(unit)), element("td", { class: "number" }, go));
    });
    this.host.replaceChildren(element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows)));
  }
}

// Findings on the mechanism, and notes on the run.
class FindingsPanel extends Panel {
  constructor(board) {
    super("Findings", board);
    this.host = element("div", { role: "status" });
    this.box.append(this.host);
  }

  update() {
    const { findings, run } = this.board;
    const found = findings && run && findings.number === run.number ? findings : null;
    const line = ([severity, , text, remedy]) => element("li", {}, element("span", { class: `badge ${severity}` }, severity), ` ${text} ${remedy}`);
    const rows = found ? found.rows.map(line) : [];
    const notes = run && run.raw ? run.notes.map((note) => line(["note", "", note, ""])) : [];
    const told = found ? found.freedom : "The mechanism is examined once the values stand still.";
    const list = rows.length + notes.length ? [element("ul", { class: "notes" }, ...rows, ...notes)] : [];
    const none = found && !list.length ? "Nothing to remark. " : "";
    this.host.replaceChildren(element("p", { class: "hint" }, none, told), ...list);
  }
}
