// Sliders, fields and switches of the values that may vary.
const STEPS_OF_A_SLIDER = 1000;

// Power of ten and unit in which the numbers of a knob are shown.
function scaleOf({ unit, low, high }) {
  return prefixed(unit, Math.max(Math.abs(low), Math.abs(high)));
}

// A number as it is typed, short, in such a unit.
function fieldText(number, [power]) {
  const value = power ? Number((number / 10 ** power).toPrecision(12)) : number;
  return Math.abs(value) < 1e-3 && value !== 0 ? value.toExponential() : String(value);
}

// Number in SI of a text that is a plain number, or one in such a unit; other texts, which are read where the mechanism runs.
function typedNumber(typed, [power, unit]) {
  const text = typed.trim().replace(",", ".");
  const [, number, exponent = 0, rest] = /^([+-]?(?:\d+\.?\d*|\.\d+))(?:e([+-]?\d+))?\s*(.*)$/i.exec(text) || [];
  return number && ["", unit, prettyUnit(unit)].includes(rest) ? Number(`${number}e${Number(exponent) + power}`) : text;
}

class Knob {
  constructor(raw, changed) {
    Object.assign(this, { raw, changed, value: null, held: false, asked: false, scale: scaleOf(raw) });
    this.box = element("div", { class: "knob" });
    const id = `knob-${raw.name}`;
    this.refused = element("p", { class: "refused", role: "alert" });
    this.refused.hidden = true;
    const field = element("span", { class: "knob-field" });
    this.box.append(element("div", { class: "knob-head" }, element("label", { htmlFor: id }, raw.name), field));
    if (raw.kind === "choice") {
      this._choice(id, field);
      if (raw.meaning) {
        this.box.append(element("div", { class: "knob-ends" }, element("span", { class: "meaning" }, raw.meaning)));
      }
    } else {
      this._number(id, field);
    }
    this.box.append(this.refused);
  }

  _choice(id, field) {
    this.select = element("select", { id }, ...this.raw.choices.map((label) => element("option", { value: label }, label)));
    this.select.addEventListener("change", () => this._give(this.select.value));
    field.append(this.select);
  }

  _number(id, field) {
    const { raw } = this;
    this.text = element("input", { type: "text", id, inputMode: "decimal", autocomplete: "off", spellcheck: false });
    this.text.addEventListener("input", () => { this.held = true; }); // what is being typed stays while runs arrive
    this.text.addEventListener("change", () => this._typed());
    this.text.addEventListener("blur", () => { this.held = false; });
    const unit = prettyUnit(this.scale[1]);
    this.text.title = unit ? `A number in ${unit}, or with another unit` : "A number";
    field.append(this.text, element("span", { class: "unit" }, unit));
    if (raw.optional) {
      this.none = element("input", { type: "checkbox" });
      this.none.addEventListener("change", () => this._give(this.none.checked ? null : this.number));
      field.append(element("label", {}, this.none, "none"));
    }
    const steps = raw.kind === "count" ? raw.high - raw.low : STEPS_OF_A_SLIDER;
    this.slider = element("input", { type: "range", min: "0", max: String(steps), step: "1", "aria-label": `Slider of ${raw.name}` });
    this.slider.addEventListener("input", () => {
      this.held = true;
      this._give(this._atPlace(Number(this.slider.value) / steps));
    });
    this.slider.addEventListener("change", () => { this.held = false; });
    const ends = element("div", { class: "knob-ends" }, element("span", {}, this.end(raw.low)));
    ends.append(element("span", { class: "meaning" }, raw.meaning), element("span", {}, this.end(raw.high)));
    this.box.append(this.slider, ends);
    this.steps = steps;
  }

  // Value at a place of the slider from 0 to 1, with four digits.
  _atPlace(place) {
    const { low, high, scale, kind } = this.raw;
    if (kind === "count") {
      return Math.round(low + place * (high - low));
    }
    const value = scale === "log" ? low * (high / low) ** place : low + place * (high - low);
    return place <= 0 ? low : place >= 1 ? high : Math.min(high, Math.max(low, Number(value.toPrecision(4))));
  }

  _place(value) {
    const { low, high, scale } = this.raw;
    return scale === "log" ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  }

  end(value) {
    return shown(value / 10 ** this.scale[0], 4);
  }

  // A value with its unit.
  told(value) {
    return typeof value !== "number" ? String(value ?? "none") : `${shown(value / 10 ** this.scale[0], 5)} ${prettyUnit(this.scale[1])}`.trim();
  }

  _typed() {
    this.held = false;
    const { low, high, kind, name } = this.raw;
    const value = typedNumber(this.text.value, this.scale);
    if (typeof value === "string") {
      this.asked = true;
      this.changed(name, value, this.value, true); // shown once it is read
      return;
    }
    const fault = value < low || value > high ? `lies outside ${this.end(low)} to ${this.told(high)}`
      : kind === "count" && !Number.isInteger(value) ? "is no whole number" : "";
    this.refuse(fault ? `${name}: ${this.told(value)} ${fault}.` : "");
    if (!fault) {
      this._give(value);
    }
  }

  refuse(text) {
    this.asked = false;
    this.refused.textContent = text;
    this.refused.hidden = !text;
    if (this.text) {
      this.text.classList.toggle("wrong", Boolean(text));
      this.text.setAttribute("aria-invalid", String(Boolean(text)));
    }
  }

  _give(value) {
    const before = this.value;
    this.show(value);
    this.changed(this.raw.name, value, before);
  }

  show(value) {
    this.value = value;
    if (this.select) {
      this.select.value = value;
      return;
    }
    if (value !== null) {
      this.number = value;
    }
    if (this.none) {
      this.none.checked = value === null;
    }
    [this.text, this.slider].forEach((input) => { input.disabled = value === null; });
    this.refuse("");
    this.text.value = fieldText(this.number, this.scale);
    if (!this.held) {
      this.slider.value = String(Math.round(this._place(this.number) * this.steps));
    }
    this.slider.setAttribute("aria-valuetext", this.told(value));
  }
}

// All knobs, their order of changes for Undo, and the values that wait to be sent.
class Values {
  constructor(send) {
    Object.assign(this, { send, knobs: new Map(), past: [], last: { name: "", at: 0 } });
    this.host = document.getElementById("knobs");
    this.length = new Knob(DATA.span, (_, ...change) => this._changed("", ...change));
    DATA.knobs.forEach((raw) => {
      const knob = new Knob(raw, (...change) => this._changed(...change));
      this.knobs.set(raw.name, knob);
      if (!DATA.hidden.includes(raw.name)) {
        this.host.append(knob.box);
      }
    });
    this.host.append(this.length.box);
    this.show(DATA.start, DATA.length);
    this._more();
    document.getElementById("undo").addEventListener("click", () => this.undo());
    document.getElementById("reset").addEventListener("click", () => this.all(DATA.start, DATA.length));
    document.getElementById("knobs-card").addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey)) {
        event.stopPropagation(); // keys of sliders and fields do not move the time
      }
    });
    document.addEventListener("keydown", (event) => {
      if ((event.ctrlKey || event.metaKey) && event.key === "z" && event.target.type !== "text") {
        this.undo();
        event.preventDefault();
      }
    });
  }

  _more() {
    const more = document.getElementById("more-knobs");
    document.getElementById("more-row").hidden = !DATA.hidden.length;
    DATA.hidden.forEach((name) => more.append(element("option", { value: name }, name)));
    more.addEventListener("change", () => {
      if (more.value) {
        this.reveal(more.value);
        more.value = "";
      }
    });
  }

  reveal(name) {
    const { box } = this.knobs.get(name);
    this.host.insertBefore(box, this.length.box);
    [...document.querySelectorAll("#more-knobs option")].filter((one) => one.value === name).forEach((one) => one.remove());
    document.getElementById("more-row").hidden = document.querySelectorAll("#more-knobs option").length < 2;
  }

  get now() {
    return Object.fromEntries([...this.knobs].map(([name, knob]) => [name, knob.value]));
  }

  _changed(name, value, before, typed) {
    const now = performance.now();
    this.fresh = name !== this.last.name || now - this.last.at > 1000; // not a part of the step before
    if (this.fresh) {
      this.past.push([name, before]);
      this.past.splice(0, this.past.length - 100);
      document.getElementById("undo").disabled = false;
    }
    this.last = { name, at: now };
    this.send(name ? { [name]: value } : {}, name ? null : value, typed);
  }

  // A refusal beside the field whose text it was; false where it belongs elsewhere.
  refuse(name, text) {
    const knob = name === "" ? this.length : this.knobs.get(name);
    if (!knob || !knob.asked) {
      return false;
    }
    knob.refuse(text.replace(/^explore: /, ""));
    this.past.splice(this.fresh ? -1 : this.past.length);
    document.getElementById("undo").disabled = !this.past.length;
    this.last = { name: "", at: 0 };
    return true;
  }

  undo() {
    const step = this.past.pop();
    document.getElementById("undo").disabled = !this.past.length;
    this.last = { name: "", at: 0 };
    if (step) {
      const [name, value] = step;
      if (name === "*") {
        this.show(value.values, value.length);
        this.send(value.values, value.length);
      } else {
        (name ? this.knobs.get(name) : this.length).show(value);
        this.send(name ? { [name]: value } : {}, name ? null : value);
      }
    }
  }

  // Set everything at once, as one step for Undo.
  all(values, length) {
    this.past.push(["*", { values: this.now, length: this.length.value }]);
    document.getElementById("undo").disabled = false;
    const known = Object.fromEntries(Object.entries(values).filter(([name]) => this.knobs.has(name)));
    this.show(known, length);
    this.send(known, length);
  }

  // Show values; those of a run (`ran`) leave a text that was refused where it is, to be mended.
  show(values, length, ran = false) {
    const entries = Object.entries(values).map(([name, value]) => [this.knobs.get(name), value]);
    [...entries, ...(length === null ? [] : [[this.length, length]])].forEach(([knob, value]) => {
      const wrong = ran && !knob.refused.hidden && value === knob.value;
      if (!knob.held && !wrong) {
        knob.show(value);
      }
    });
  }
}
