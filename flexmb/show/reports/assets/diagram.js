// Points and lines over two axes, on a canvas: drag pans, the wheel zooms once the canvas has the focus.
const DIAGRAM_MARGIN = { left: 66, right: 26, top: 12, bottom: 40 };

class Diagram {
  constructor(canvas, { onPick = null, equal = false } = {}) {
    Object.assign(this, { canvas, onPick, equal, groups: [], lines: [], labels: ["", ""], units: ["", ""], chosen: null, drawn: 0 });
    new ResizeObserver(() => this.draw()).observe(canvas);
    onTheme(() => this.draw());
    this._listen();
  }

  // Groups { x, y, style, marker, tags, under } of points, which lie under the lines or above them, and lines { x, y, style }.
  show(groups, lines, labels, units) {
    Object.assign(this, { groups, lines, labels, units });
    this.fit();
  }

  fit() {
    const all = [...this.groups, ...this.lines];
    this.x = limitsOf(all.map((one) => one.x));
    this.y = limitsOf(all.map((one) => one.y));
    this.draw();
  }

  get area() {
    const m = DIAGRAM_MARGIN;
    const [width, height] = [this.canvas.clientWidth - m.left - m.right, this.canvas.clientHeight - m.top - m.bottom];
    return { left: m.left, top: m.top, width: Math.max(width, 1), height: Math.max(height, 1) };
  }

  // Scales of both axes; one scale where both have the same unit.
  _scales() {
    const area = this.area;
    const [sx, sy] = [area.width / (this.x[1] - this.x[0]), area.height / (this.y[1] - this.y[0])];
    return this.equal ? [Math.min(sx, sy), Math.min(sx, sy)] : [sx, sy];
  }

  screen(x, y) {
    const area = this.area;
    const [sx, sy] = this._scales();
    const [mx, my] = [(this.x[0] + this.x[1]) / 2, (this.y[0] + this.y[1]) / 2];
    return [area.left + area.width / 2 + (x - mx) * sx, area.top + area.height / 2 - (y - my) * sy];
  }

  world(px, py) {
    const area = this.area;
    const [sx, sy] = this._scales();
    const [mx, my] = [(this.x[0] + this.x[1]) / 2, (this.y[0] + this.y[1]) / 2];
    return [mx + (px - area.left - area.width / 2) / sx, my - (py - area.top - area.height / 2) / sy];
  }

  draw() {
    if (!this.x) {
      return;
    }
    const { context } = fitted(this.canvas);
    const area = this.area;
    context.clearRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    this._axes(context, area);
    context.save();
    context.beginPath();
    context.rect(area.left, area.top, area.width, area.height);
    context.clip();
    const many = this.groups.reduce((sum, group) => sum + group.x.length, 0);
    const size = many > 4000 ? 1.1 : many > 800 ? 1.8 : 2.8;
    this.groups.filter((group) => group.under).forEach((group) => this._points(context, group, size));
    this.lines.forEach((line) => this._line(context, line));
    this.groups.filter((group) => !group.under).forEach((group) => this._points(context, group, size));
    if (this.chosen !== null) {
      const [px] = this.screen(this.chosen, 0);
      context.fillStyle = colour("alert");
      context.fillRect(px - 1, area.top, 2, area.height);
    }
    context.restore();
    this.drawn += 1;
  }

  _axes(context, area) {
    const [x0, y1] = this.world(area.left, area.top);
    const [x1, y0] = this.world(area.left + area.width, area.top + area.height);
    context.font = "11px system-ui, sans-serif";
    context.lineWidth = 1;
    context.strokeStyle = colour("grid");
    context.fillStyle = colour("muted");
    context.textBaseline = "middle";
    context.textAlign = "center";
    const [across, up] = [[x0, x1], [y0, y1]].map(([low, high], k) => {
      return prefixed(this.units[k], Math.max(Math.abs(low), Math.abs(high)));
    });
    ticksOf(x0, x1, area.width / 90).forEach((tick) => {
      const [px] = this.screen(tick, 0);
      context.strokeRect(px, area.top, 0, area.height);
      context.fillText(shown(tick / 10 ** across[0], 6), px, area.top + area.height + 10);
    });
    context.textAlign = "right";
    ticksOf(y0, y1, area.height / 45).forEach((tick) => {
      const [, py] = this.screen(0, tick);
      context.strokeRect(area.left, py, area.width, 0);
      context.fillText(shown(tick / 10 ** up[0], 6), area.left - 6, py);
    });
    context.strokeStyle = colour("line");
    context.strokeRect(area.left, area.top, area.width, area.height);
    context.fillStyle = colour("text");
    context.textAlign = "center";
    context.font = "12px system-ui, sans-serif";
    context.fillText(labelled(this.labels[0], across[1]), area.left + area.width / 2, area.top + area.height + 28);
    context.save();
    context.translate(10, area.top + area.height / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(labelled(this.labels[1], up[1]), 0, 0);
    context.restore();
  }

  _line(context, line) {
    context.strokeStyle = line.style();
    context.lineWidth = line.width || 1;
    context.setLineDash(line.dash || []);
    context.beginPath();
    let open = false;
    for (let i = 0; i < line.x.length; i += 1) {
      const inside = Number.isFinite(line.x[i]) && Number.isFinite(line.y[i]);
      if (inside) {
        const [px, py] = this.screen(line.x[i], line.y[i]);
        if (open) {
          context.lineTo(px, py);
        } else {
          context.moveTo(px, py);
        }
      }
      open = inside;
    }
    context.stroke();
    context.setLineDash([]);
  }

  _points(context, group, size) {
    context.fillStyle = group.style();
    context.beginPath();
    for (let i = 0; i < group.x.length; i += 1) {
      if (Number.isFinite(group.x[i]) && Number.isFinite(group.y[i])) {
        const [px, py] = this.screen(group.x[i], group.y[i]);
        const turn = { up: -1, down: 1 }[group.marker];
        if (turn) {
          context.moveTo(px, py + turn * 1.4 * size);
          context.lineTo(px - 1.3 * size, py - turn * size);
          context.lineTo(px + 1.3 * size, py - turn * size);
        } else {
          context.moveTo(px + size, py);
          context.arc(px, py, size, 0, 2 * Math.PI);
        }
      }
    }
    context.fill();
  }

  // Tag of the point that is nearest to a place on the screen, within some pixels.
  nearest(px, py) {
    let best = { distance: 14, tag: null };
    this.groups.forEach((group) => {
      for (let i = 0; i < group.x.length; i += 1) {
        const [qx, qy] = this.screen(group.x[i], group.y[i]);
        const distance = Math.hypot(qx - px, qy - py);
        if (distance < best.distance) {
          best = { distance, tag: group.tags ? group.tags[i] : i };
        }
      }
    });
    return best.tag;
  }

  _listen() {
    const { canvas } = this;
    let held = null;
    let moved = 0;
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      [held, moved] = [place(event), 0];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (held) {
        const now = place(event);
        moved += Math.hypot(now[0] - held[0], now[1] - held[1]);
        if (moved > 4) {
          const [from, to] = [this.world(...held), this.world(...now)];
          this.x = this.x.map((value) => value + from[0] - to[0]);
          this.y = this.y.map((value) => value + from[1] - to[1]);
          this.draw();
        }
        held = now;
      }
    });
    canvas.addEventListener("pointerup", (event) => {
      if (held && moved <= 4 && this.onPick) {
        const tag = this.nearest(...place(event));
        if (tag !== null) {
          this.onPick(tag);
        }
      }
      held = null;
    });
    canvas.addEventListener("pointercancel", () => { held = null; });
    canvas.addEventListener("dblclick", () => this.fit());
    canvas.addEventListener("wheel", (event) => {
      if (event.ctrlKey || document.activeElement === canvas) {
        event.preventDefault();
        this.zoom(Math.exp(0.0015 * event.deltaY), place(event));
      }
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const factors = { "+": 0.8, "=": 0.8, "-": 1.25 };
      if (event.key in factors) {
        this.zoom(factors[event.key], [canvas.clientWidth / 2, canvas.clientHeight / 2]);
        event.preventDefault();
      } else if (event.key === "0") {
        this.fit();
      }
    });
  }

  zoom(factor, at) {
    const [x, y] = this.world(...at);
    this.x = this.x.map((value) => x + factor * (value - x));
    this.y = this.y.map((value) => y + factor * (value - y));
    this.draw();
  }
}

// Smallest and largest of all finite numbers, with a margin.
function limitsOf(lists) {
  let [low, high] = [Infinity, -Infinity];
  lists.forEach((list) => list.forEach((value) => {
    if (Number.isFinite(value)) {
      [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
  }));
  if (low > high) {
    return [-1, 1];
  }
  const margin = high > low ? 0.05 * (high - low) : 0.05 * Math.abs(high) || 1;
  return [low - margin, high + margin];
}

// Round numbers between two limits, about so many.
function ticksOf(low, high, count) {
  const wanted = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].map((m) => m * power).find((one) => one >= wanted);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high; k += 1) {
    found.push(Math.abs(k * step) < 1e-9 * step ? 0 : k * step);
  }
  return found;
}

function labelled(name, unit) {
  return unit ? `${name} [${prettyUnit(unit)}]` : name;
}

function fillChoice(choice, names, chosen) {
  names.forEach((name) => choice.append(element("option", { value: name }, name)));
  choice.value = chosen;
}
