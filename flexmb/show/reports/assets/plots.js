// Plots of signals over time, linked with the time of the page.
const READOUT_PAUSE = 120; // between two readouts while the mechanism moves [ms]

class Plots {
  static async of(raw, clock) {
    const [times, curves, frames, own] = await Promise.all([
      columnsOf(raw.abscissae),
      columnsOf(raw.curves),
      columnsOf(raw.time),
      raw.at_frames ? columnsOf(raw.at_frames) : Promise.resolve(null),
    ]);
    const values = own || curves.map((curve) => Float64Array.from(raw.rows, (row) => curve[row]));
    return new Plots(raw, clock, times[0], curves, frames[0], values);
  }

  constructor(raw, clock, times, curves, frames, values) {
    Object.assign(this, { raw, clock, times, curves, frames, values, made: [], window: null });
    onTheme(() => this.made.forEach((panel) => panel.plot.redraw()));
  }

  // Whether a signal is ever another value than 0.
  varies(name) {
    return this.curves[this.raw.names.indexOf(name)].some((value) => value !== 0);
  }

  // A panel for some signals, at the end of a host element.
  add(host, names, { height = 118, removable = true } = {}) {
    const places = names.map((name) => this.raw.names.indexOf(name)).filter((k) => k >= 0);
    if (!places.length) {
      return null;
    }
    const readouts = places.map(() => element("output"));
    const legend = element("div", { class: "keys" });
    places.forEach((place, k) => {
      const key = element("span", { class: `key key-${seriesNumber(k)}` });
      legend.append(element("span", { class: "entry" }, key, this.raw.names[place], " ", readouts[k]));
    });
    const largest = places.reduce((most, place) => Math.max(most, largestOf(this.curves[place])), 0);
    const [power, text] = prefixed(this.raw.units[places[0]], largest);
    const unit = prettyUnit(text);
    legend.append(element("span", { class: "unit" }, unit ? `[${unit}]` : ""));
    const box = element("div", { class: "panel", role: "group", "aria-label": `Plot of ${names.join(", ")} over time` });
    const heading = element("div", { class: "panel-head" }, legend);
    const area = element("div", { class: "area" });
    box.append(heading, area);
    host.append(box);
    const panel = { box, places, readouts, scale: 10 ** -power, plot: this._plot(area, places, height, 10 ** -power) };
    if (removable) {
      const close = element("button", { type: "button", class: "close", "aria-label": `Remove ${names.join(", ")}` }, "\u00d7");
      close.addEventListener("click", () => this.remove(panel));
      heading.append(close);
    }
    panel.plot.root.setAttribute("aria-hidden", "true");
    panel.line = element("div", { class: "now-line" });
    panel.plot.over.append(panel.line);
    this.made.push(panel);
    this._listen(panel);
    panel.observer = new ResizeObserver(() => {
      if (area.clientWidth && area.clientWidth !== panel.plot.width) {
        panel.plot.setSize({ width: area.clientWidth, height });
        this._show(panel);
      }
    });
    panel.observer.observe(area);
    this._show(panel);
    return panel;
  }

  remove(panel) {
    panel.observer.disconnect();
    panel.plot.destroy();
    panel.box.remove();
    this.made = this.made.filter((other) => other !== panel);
  }

  _plot(area, places, height, scale) {
    const axis = { stroke: () => colour("muted"), grid: { stroke: () => colour("grid"), width: 1 } };
    axis.ticks = { stroke: () => colour("grid"), width: 1, size: 4 };
    axis.font = "11px system-ui, sans-serif";
    const numbers = (plot, splits) => splits.map((value) => shown(value, 6));
    const scaled = (plot, splits) => splits.map((value) => shown(value * scale, 6));
    const options = {
      width: Math.max(area.clientWidth, 120),
      height,
      legend: { show: false },
      padding: [6, 8, 0, 0],
      hooks: { draw: [(plot) => this.made.filter((one) => one.plot === plot).forEach((one) => this._show(one))] },
      cursor: { drag: { x: false, y: false, setScale: false }, points: { show: false }, y: false },
      scales: { x: { time: false, range: () => this.window || this._span() } },
      axes: [
        { ...axis, size: 22, gap: 3, values: numbers, space: 70 },
        { ...axis, size: 62, gap: 3, values: scaled, space: 24 },
      ],
      series: [{}, ...places.map((_, k) => ({ stroke: () => seriesColour(k), width: 1.3, dash: k > seriesNumber(k) ? [6, 3] : undefined, points: { show: false } }))],
    };
    const stepped = places.every((place) => this.raw.names[place].endsWith(".mode"));
    if (stepped) {
      options.series.slice(1).forEach((one) => { one.paths = uPlot.paths.stepped({ align: 1 }); });
    }
    return new uPlot(options, [this.times, ...places.map((place) => this.curves[place])], area);
  }

  _span() {
    const [first, last] = [this.times[0], this.times[this.times.length - 1]];
    return last > first ? [first, last] : [first - 0.5, first + 0.5];
  }

  // Click and drag set the time, Shift and drag zoom, a double click shows all.
  _listen(panel) {
    const over = panel.plot.over;
    let zoomFrom = null;
    const timeAt = (event) => panel.plot.posToVal(event.clientX - over.getBoundingClientRect().left, "x");
    over.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) {
        return;
      }
      over.setPointerCapture(event.pointerId);
      zoomFrom = event.shiftKey ? timeAt(event) : null;
      if (zoomFrom === null) {
        this.clock.goTo(timeAt(event));
      }
    });
    over.addEventListener("pointermove", (event) => {
      if (event.buttons & 1 && zoomFrom === null) {
        this.clock.goTo(timeAt(event));
      }
    });
    over.addEventListener("pointerup", (event) => {
      if (zoomFrom !== null) {
        const limits = [zoomFrom, timeAt(event)].sort((a, b) => a - b);
        if (limits[1] > limits[0]) {
          this.zoom(limits);
        }
      }
    });
    over.addEventListener("dblclick", () => this.zoom(null));
  }

  zoom(limits) {
    this.window = limits;
    const [min, max] = limits || this._span();
    this.made.forEach((panel) => {
      panel.plot.setScale("x", { min, max });
      this._show(panel);
    });
  }

  show() {
    this.made.forEach((panel) => this._show(panel));
  }

  _show(panel) {
    const k = this.clock.frame;
    const x = panel.plot.valToPos(this.frames[k], "x");
    const inside = x > -0.5 && x < panel.plot.over.clientWidth + 0.5; // round-off at both ends
    panel.line.style.visibility = inside ? "visible" : "hidden";
    panel.line.style.transform = `translateX(${x}px)`;
    if (!this.clock.playing || performance.now() - (panel.told || 0) > READOUT_PAUSE) {
      panel.told = performance.now();
      panel.places.forEach((place, n) => { panel.readouts[n].textContent = shown(this.values[place][k] * panel.scale); });
    }
  }
}
