// Data of the page: numbers that packing.py compressed.
const DATA = JSON.parse(document.getElementById("data").textContent);

async function inflated(text) {
  const packed = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Columns of an array as Float64Array (n); floats keep seven digits.
async function columnsOf(packed) {
  const bytes = await inflated(packed.data);
  if (packed.size === 8) {
    return [doublesOf(bytes, packed.n)];
  }
  const found = [];
  for (let j = 0; j < packed.m; j += 1) {
    found.push(packed.size === 4 ? floatsOf(bytes, packed, j) : wholeOf(bytes, packed, j));
  }
  return found;
}

// Whole numbers of a column: sums of its differences, whose bytes lie in planes, lowest first.
function summed(bytes, packed, j) {
  const total = packed.n * packed.m;
  const values = new Uint32Array(packed.n);
  let value = 0;
  for (let i = 0; i < packed.n; i += 1) {
    let step = 0;
    for (let plane = packed.size - 1; plane >= 0; plane -= 1) {
      step = ((step << 8) | bytes[plane * total + j * packed.n + i]) >>> 0;
    }
    value = (value + step) >>> 0;
    values[i] = packed.size === 4 ? value : value % 2 ** (8 * packed.size);
  }
  return values;
}

function floatsOf(bytes, packed, j) {
  return Float64Array.from(new Float32Array(summed(bytes, packed, j).buffer));
}

function wholeOf(bytes, packed, j) {
  const low = packed.low[packed.low.length > 1 ? j : 0];
  const step = packed.step[packed.step.length > 1 ? j : 0];
  return Float64Array.from(summed(bytes, packed, j), (whole) => low + step * whole);
}

function doublesOf(bytes, n) {
  const ordered = new Uint8Array(8 * n);
  for (let i = 0; i < n; i += 1) {
    for (let plane = 0; plane < 8; plane += 1) {
      ordered[8 * i + plane] = bytes[plane * n + i];
    }
  }
  return new Float64Array(ordered.buffer);
}

// A number with so many significant digits, short.
function shown(value, digits = 5) {
  if (value === null || value === undefined || !Number.isFinite(value)) {
    return "-";
  }
  if (value === 0) {
    return "0";
  }
  const power = Math.floor(Math.log10(Math.abs(value)));
  if (power < -4 || power > 5) {
    return value.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e");
  }
  return String(Number(value.toPrecision(digits)));
}

// Power of ten and unit with a prefix for numbers up to `largest`, as `prefixed` in flexmb/show/pictures/style.py has them.
function prefixed(unit, largest) {
  const takes = /^(m|s|N|Pa|J|W|Hz|A|V)(?![A-Za-z0-9^])/.exec(unit);
  const power = 3 * Math.floor(Math.log10(largest) / 3);
  const prefix = { "-9": "n", "-6": "\u00b5", "-3": "m", 3: "k", 6: "M", 9: "G" }[power];
  const fits = takes && largest > 0 && prefix && (largest < 0.1 || largest >= 1e4);
  return fits && !(power > 0 && "ms".includes(takes[1])) ? [power, prefix + unit] : [0, unit];
}

// Largest absolute value of a curve.
function largestOf(curve) {
  return curve.reduce((most, value) => Math.max(most, Number.isFinite(value) ? Math.abs(value) : 0), 0);
}

// A number in a unit with prefix.
function withUnit(value, unit, digits = 3) {
  const [power, text] = prefixed(unit, Math.abs(value));
  return `${shown(value / 10 ** power, digits)} ${prettyUnit(text)}`;
}

function prettyUnit(unit) {
  return unit.replace("^2", "\u00b2").replace("s2", "s\u00b2").replace("m2", "m\u00b2").replace("^3", "\u00b3");
}

// Number of the last time that is not after t, in increasing times.
function placeOf(times, t) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}

// Number of the time that is nearest to t.
function nearestPlace(times, t) {
  const k = placeOf(times, t);
  return k + 1 < times.length && times[k + 1] - t < t - times[k] ? k + 1 : k;
}

function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key === "class") {
      made.className = value;
    } else if (key.startsWith("aria") || key.startsWith("data-")) {
      made.setAttribute(key, value);
    } else {
      made[key] = value;
    }
  }
  made.append(...children);
  return made;
}
