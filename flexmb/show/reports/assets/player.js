// Time of the page: played, stepped, or set by hand.
class Clock {
  constructor(times, stats) {
    Object.assign(this, { times, stats, frame: 0, time: times[0], playing: false, actions: [], duration: 10 });
  }

  get last() {
    return this.times.length - 1;
  }

  get span() {
    return this.times[this.last] - this.times[0];
  }

  onChange(action) {
    this.actions.push(action);
  }

  changed() {
    this.actions.forEach((action) => action());
  }

  goTo(time) {
    this.time = Math.min(Math.max(time, this.times[0]), this.times[this.last]);
    this._showFrame(nearestPlace(this.times, this.time));
  }

  goToFrame(frame) {
    const k = Math.min(Math.max(frame, 0), this.last);
    this.time = this.times[k];
    this._showFrame(k);
  }

  _showFrame(frame) {
    if (frame !== this.frame) {
      this.frame = frame;
      this.changed();
    }
  }

  play(on) {
    if (on === this.playing || (on && this.last === 0)) {
      return;
    }
    this.playing = on;
    if (on) {
      if (this.frame === this.last) {
        this.goToFrame(0);
      }
      let before = null;
      const tick = (now) => {
        if (!this.playing) {
          return;
        }
        const passed = before === null ? 0 : Math.min((now - before) / 1000, 0.25);
        before = now;
        this._advance(passed);
        this.stats.ticks += 1;
        requestAnimationFrame(tick);
      };
      requestAnimationFrame(tick);
    }
    this.changed();
  }

  // Time goes on by so many seconds on the clock; after the end it begins again.
  _advance(passed) {
    const rate = this.duration === "real" ? 1 : this.span / this.duration;
    const next = this.time + passed * rate;
    if (next > this.times[this.last]) {
      this.goToFrame(0);
    } else {
      this.goTo(next);
    }
  }
}

// Controls of clock and picture, by mouse, touch and keyboard.
class Controls {
  constructor(clock, picture) {
    Object.assign(this, { clock, picture, said: 0 });
    this.slider = document.getElementById("time");
    this.slider.max = String(clock.last);
    this._buttons();
    this._choices();
    this._keys();
    this._pointer();
    clock.onChange(() => this.show());
    new ResizeObserver(() => this.redraw()).observe(picture.canvas);
    onTheme(() => this.redraw());
    this.show();
  }

  redraw() {
    this.picture.draw(this.clock.frame);
    this._legend();
  }

  show() {
    const { clock } = this;
    const text = `t = ${shown(clock.times[clock.frame], 6)} s`;
    document.getElementById("now").textContent = text;
    this.slider.value = String(clock.frame);
    this.slider.setAttribute("aria-valuetext", text);
    const play = document.getElementById("play");
    const word = clock.playing ? "Pause" : "Play";
    if (play.textContent !== word) {
      play.textContent = word;
      play.setAttribute("aria-pressed", String(clock.playing));
    }
    this._say(text);
    this.picture.draw(clock.frame);
  }

  // Time for screen readers, once it stands still.
  _say(text) {
    clearTimeout(this.saying);
    if (!this.clock.playing) {
      this.saying = setTimeout(() => { document.getElementById("said").textContent = text; }, 400);
    }
  }

  _on(id, event, action) {
    const found = document.getElementById(id);
    if (found) {
      found.addEventListener(event, () => action(found));
    }
  }

  _buttons() {
    const { clock, picture } = this;
    this._on("play", "click", () => clock.play(!clock.playing));
    this._on("back", "click", () => this._step(-1));
    this._on("forward", "click", () => this._step(1));
    this.slider.addEventListener("input", () => {
      clock.play(false);
      clock.goToFrame(Number(this.slider.value));
    });
    this._on("fit", "click", () => { picture.fit(); this.redraw(); });
    this._on("clear", "click", () => { picture.traces = []; this.redraw(); });
  }

  _step(frames) {
    this.clock.play(false);
    this.clock.goToFrame(this.clock.frame + frames);
  }

  _choices() {
    const { clock, picture } = this;
    this._on("duration", "change", (choice) => { clock.duration = choice.value === "real" ? "real" : Number(choice.value); });
    this._on("magnification", "change", (choice) => this._magnify(choice.value));
    this._on("colour", "change", (choice) => { picture.look.colour = choice.value; this.redraw(); });
    this._on("forces", "change", (box) => { picture.look.forces = box.checked; this.redraw(); });
    this._on("names", "change", (box) => { picture.look.names = box.checked; this.redraw(); });
    const colours = document.getElementById("colour");
    if (colours) {
      picture.look.colour = colours.value;
      this._magnify(document.getElementById("magnification").value);
    }
  }

  _magnify(value) {
    const { scene, size } = this.picture;
    scene.magnification = value === "auto" ? scene.suggestedMagnification(size) : Number(value);
    this.redraw();
  }

  _keys() {
    const steps = { ArrowLeft: -1, ArrowRight: 1 };
    document.addEventListener("keydown", (event) => {
      const target = event.target;
      const busy = ["SELECT", "BUTTON", "A", "SUMMARY"].includes(target.tagName) || target.type === "checkbox";
      if (event.ctrlKey || event.metaKey || event.altKey || (busy && [" ", "Enter"].includes(event.key))) {
        return;
      }
      if (target.tagName === "SELECT" || (target.classList.contains("scroll") && event.key.startsWith("Arrow"))) {
        return;
      }
      if (event.key in steps) {
        this._step(steps[event.key] * (event.shiftKey ? 10 : 1));
      } else if (event.key === " ") {
        this.clock.play(!this.clock.playing);
      } else if (event.key === "Home" || event.key === "End") {
        this._step(event.key === "Home" ? -this.clock.last : this.clock.last);
      } else if (["+", "=", "-"].includes(event.key)) {
        this.picture.zoom(event.key === "-" ? 1 / 1.25 : 1.25);
        this.redraw();
      } else if (event.key === "0") {
        this.picture.fit();
        this.redraw();
      } else {
        return;
      }
      event.preventDefault();
    });
  }

  // Drag pans, two fingers zoom, the wheel zooms once the picture has the focus, a click traces the nearest point.
  _pointer() {
    const { canvas } = this.picture;
    const held = new Map();
    let moved = 0;
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, place(event));
      moved = held.size > 1 ? 100 : 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      const now = place(event);
      if (!before) {
        this._point(now);
        return;
      }
      moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
      const other = [...held].filter(([id]) => id !== event.pointerId).map(([, at]) => at)[0];
      if (other) {
        const far = ([x, y]) => Math.hypot(x - other[0], y - other[1]) || 1;
        this.picture.zoom(far(now) / far(before), other);
      } else if (moved > 4) {
        this.picture.pan(now[0] - before[0], now[1] - before[1]);
      }
      held.set(event.pointerId, now);
      this.redraw();
    });
    ["pointerup", "pointercancel"].forEach((kind) => canvas.addEventListener(kind, (event) => {
      if (kind === "pointerup" && held.has(event.pointerId) && moved <= 4) {
        this._trace(place(event));
      }
      held.delete(event.pointerId);
    }));
    canvas.addEventListener("wheel", (event) => {
      if (event.ctrlKey || document.activeElement === canvas) {
        event.preventDefault();
        this.picture.zoom(Math.exp(-0.0015 * event.deltaY), place(event));
        this.redraw();
      }
    }, { passive: false });
  }

  // Name of the part under the pointer.
  _point(place) {
    const { picture } = this;
    const pick = picture.scene.nearest(...picture.world(...place));
    const hover = pick.distance * picture.scale < 10 ? { part: pick.part, px: place[0], py: place[1] } : null;
    if (hover || picture.hover) {
      picture.hover = hover;
      this.redraw();
    }
  }

  _trace(place) {
    const { picture } = this;
    const pick = picture.scene.nearest(...picture.world(...place));
    if (pick.distance * picture.scale < 16) {
      picture.traces.push(pick);
      this.redraw();
    }
  }

  // Meaning of colours and arrows.
  _legend() {
    const { picture } = this;
    const lines = [];
    const names = { moment: ["bending moment", "N m"], axial: ["axial force", "N"], stress: ["stress", "Pa"] };
    const field = names[picture.look.colour];
    const box = document.getElementById("legend");
    box.classList.toggle("one-sided", picture.look.colour === "stress");
    box.classList.toggle("field", Boolean(field) && picture.limits[picture.look.colour] > 0);
    const ticks = document.getElementById("legend-ticks");
    ticks.replaceChildren();
    if (field) {
      const limit = picture.limits[picture.look.colour];
      const [power, unit] = prefixed(field[1], limit);
      const places = picture.look.colour === "stress" ? [0, 0.25, 0.5, 0.75, 1] : [-1, -0.5, 0, 0.5, 1];
      ticks.append(...places.map((place) => element("span", {}, shown((place * limit) / 10 ** power, 3))));
      lines.push(`${field[0]} [${prettyUnit(unit)}], ${shown(limit / 10 ** power, 3)} and beyond in the last colour`);
    }
    if (picture.look.forces && picture.limits.force > 0) {
      lines.push(`joint forces, on the second bodies: ${ARROW} px are ${withUnit(picture.limits.force, "N")}`);
    }
    lines.push(`grid: ${shown(picture.spacing, 3)} m`);
    if (picture.scene.magnification > 1) {
      lines.push(`deformation ${picture.scene.magnification} \u00d7`);
    }
    document.getElementById("legend-text").textContent = lines.join("; ");
  }
}
