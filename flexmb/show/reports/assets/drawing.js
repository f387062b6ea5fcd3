// Picture of the mechanism on a canvas.
const BINS = 33;
const LEVELS = 64;
const PIECES = 8;
const ARROW = 64; // length of an arrow of the reference force [px]
const FONT = "12px system-ui, sans-serif";
const LONGEST = 2; // longest arrow over that length

class Picture {
  constructor(canvas, scene) {
    Object.assign(this, { canvas, scene, look: { colour: "part", forces: true, names: true }, traces: [], drawn: 0 });
    this.placeOf = {}; // number of the place of each name in the frame before
    this.box = scene.limits();
    this.size = Math.max(this.box[1] - this.box[0], this.box[3] - this.box[2], 1e-9);
    this.limits = {
      moment: largeValue(scene.columns.moment, 0.98),
      axial: largeValue(scene.columns.axial, 0.98),
      stress: largeValue([...scene.columns.stress, ...scene.meshes.flatMap((mesh) => mesh.stress)], 0.98),
      force: this._referenceForce(),
    };
    this.small = scene.raw.points.length > 25 ? 0.55 : 1; // size of joints, where they are many
    this.markers = scene.raw.points.filter((p) => p.kind === "trace").map((p) => ({ place: p.at }));
    this.fit();
  }

  _referenceForce() {
    const forces = this.scene.columns.forces;
    const sizes = [];
    for (let k = 0; k + 1 < forces.length; k += 2) {
      sizes.push(forces[k].map((fx, i) => Math.hypot(fx, forces[k + 1][i])));
    }
    return largeValue(sizes, 0.95);
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [x0, x1, y0, y1] = this.box;
    const margin = 0.09 * this.size;
    this.scale = Math.min(width / (x1 - x0 + 2 * margin), (height - 30) / (y1 - y0 + 2 * margin));
    this.middle = [(x0 + x1) / 2, (y0 + y1) / 2 - 15 / this.scale];
    this.fittedTo = [width, height];
  }

  zoom(factor, at = null) {
    const [px, py] = at || [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2];
    const [x, y] = this.world(px, py);
    this.scale *= factor;
    const [qx, qy] = this.world(px, py);
    this.middle = [this.middle[0] + x - qx, this.middle[1] + y - qy];
  }

  pan(dx, dy) {
    this.middle = [this.middle[0] - dx / this.scale, this.middle[1] + dy / this.scale];
  }

  world(px, py) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return [this.middle[0] + (px - width / 2) / this.scale, this.middle[1] - (py - height / 2) / this.scale];
  }

  screen([x, y]) {
    return [this.half[0] + (x - this.middle[0]) * this.scale, this.half[1] - (y - this.middle[1]) * this.scale];
  }

  draw(k) {
    const { context, width, height } = fitted(this.canvas);
    if (this.fittedTo[0] !== width || this.fittedTo[1] !== height) {
      this.fit();
    }
    this.half = [width / 2, height / 2];
    this.context = context;
    this.frame = k;
    context.clearRect(0, 0, width, height);
    context.lineCap = "round";
    context.lineJoin = "round";
    this.scene.moveTo(k);
    this.lines = []; // what names shall not hide, as pairs of points of the screen
    this._grid(width, height);
    this._paths();
    this.scene.raw.symbols.forEach((symbol) => this._symbol(symbol));
    this._bodies();
    this.scene.raw.points.forEach((point) => this._joint(point));
    if (this.look.forces) {
      this._forces();
    }
    if (this.look.names) {
      this._names(width);
    }
    if (this.hover) {
      this._label(this.hover.part, this.hover.px + 12, this.hover.py - 14);
    }
    this.drawn += 1;
  }

  // Grid of round distances, and the scale.
  _grid(width, height) {
    const context = this.context;
    const wanted = 90 / this.scale;
    const power = 10 ** Math.floor(Math.log10(wanted));
    this.spacing = [1, 2, 5, 10].map((m) => m * power).find((step) => step >= wanted);
    context.strokeStyle = colour("grid");
    context.lineWidth = 1;
    context.beginPath();
    const [x0, y1] = this.world(0, 0);
    const [x1, y0] = this.world(width, height);
    for (let k = Math.ceil(x0 / this.spacing); k * this.spacing <= x1; k += 1) {
      const [px] = this.screen([k * this.spacing, 0]);
      context.moveTo(px, 0);
      context.lineTo(px, height);
    }
    for (let k = Math.ceil(y0 / this.spacing); k * this.spacing <= y1; k += 1) {
      const [, py] = this.screen([0, k * this.spacing]);
      context.moveTo(0, py);
      context.lineTo(width, py);
    }
    context.stroke();
  }

  _line(points) {
    points.forEach((point, k) => {
      const [px, py] = this.screen(point);
      if (k) {
        this.context.lineTo(px, py);
      } else {
        this.context.moveTo(px, py);
      }
    });
  }

  // Paths of markers and of clicked points, with the present place.
  _paths() {
    [...this.markers, ...this.traces].forEach((trace) => {
      if (trace.magnification !== this.scene.magnification) {
        trace.points = this.scene.path(trace);
        trace.magnification = this.scene.magnification;
      }
      this._stroke(colour("trace"), 1.4, () => this._line(trace.points));
      this._dot(trace.points[this.frame], 3.5, colour("trace"));
    });
  }

  _stroke(style, width, draw, dash = []) {
    const context = this.context;
    context.strokeStyle = style;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.beginPath();
    draw();
    context.stroke();
    context.setLineDash([]);
  }

  _dot(point, radius, style) {
    const [px, py] = this.screen(point);
    this.context.fillStyle = style;
    this.context.beginPath();
    this.context.arc(px, py, radius, 0, 2 * Math.PI);
    this.context.fill();
  }

  _bodies() {
    const { raw, magnification, numberOf } = this.scene;
    raw.rigid.forEach((shape) => {
      const style = seriesColour(numberOf[shape.part]);
      shape.lines.forEach((line) => {
        const points = line.map((p) => this.scene.point([shape.node, ...p]));
        const still = points.length === 1 || points.every((p) => p[0] === points[0][0] && p[1] === points[0][1]);
        if (still) {
          this._dot(points[0], 6, style);
        } else {
          this._stroke(style, 3, () => this._line(points));
          this._keepFree(points.map((point) => this.screen(point)));
        }
      });
    });
    const cubics = raw.beams.map((_, b) => this.scene.beam(b));
    cubics.forEach((cubic) => this._keepFree([0, 0.5, 1].map((share) => this.screen(alongCubic(cubic, share)))));
    if (magnification > 1) {
      this._unmagnified();
    }
    this.scene.meshes.forEach((mesh) => this._mesh(mesh, seriesColour(numberOf[mesh.raw.part])));
    const field = this.scene.columns[this.look.colour];
    if (field && field.length && this.limits[this.look.colour] > 0) {
      this._coloured(cubics, field, this.limits[this.look.colour]);
    } else {
      this._plainBeams(cubics);
    }
  }

  // Mesh with the stress of its triangles between its outlines, or in the colour of its body.
  _mesh(mesh, style) {
    const { context } = this;
    const { raw, stress } = mesh;
    const points = Array.from(mesh.x, (x, i) => this.screen([x, mesh.y[i]]));
    const outlines = new Path2D();
    raw.loops.forEach((loop) => {
      loop.forEach((i, k) => (k ? outlines.lineTo(...points[i]) : outlines.moveTo(...points[i])));
      outlines.closePath();
    });
    const limit = this.limits.stress;
    if (this.look.colour === "stress" && stress.length && limit > 0) {
      context.save();
      context.clip(outlines, "evenodd");
      context.fillStyle = stressColour(0);
      context.fill(outlines, "evenodd");
      mesh.inColours(this.frame, (value) => Math.round(LEVELS * Math.min(1, value / limit))).forEach((triangles, level) => {
        context.fillStyle = context.strokeStyle = stressColour(level);
        context.lineWidth = 0.6; // else lines of the background shine through between triangles
        context.beginPath();
        triangles.forEach((t) => {
          context.moveTo(...points[raw.triangles[t]]);
          context.lineTo(...points[raw.triangles[t + 1]]);
          context.lineTo(...points[raw.triangles[t + 2]]);
          context.closePath();
        });
        context.fill();
        context.stroke();
      });
      context.restore();
    } else {
      context.globalAlpha = 0.16;
      context.fillStyle = style;
      context.fill(outlines, "evenodd");
      context.globalAlpha = 1;
    }
    context.strokeStyle = style;
    context.lineWidth = 1.6;
    context.stroke(outlines);
    raw.loops.forEach((loop) => this._keepFree(loop.map((i) => points[i])));
  }

  // Beams and outlines without magnification, thin, behind the magnified ones.
  _unmagnified() {
    const factor = this.scene.magnification;
    this.scene.magnification = 1;
    this.scene.moveTo(this.frame);
    this._stroke(colour("faint"), 1.2, () => this.scene.raw.beams.forEach((_, b) => this._cubicPath(this.scene.beam(b))));
    this.scene.meshes.forEach((mesh) => mesh.raw.loops.forEach((loop) => {
      this._stroke(colour("faint"), 1, () => this._line([...loop, loop[0]].map((i) => [mesh.x[i], mesh.y[i]])));
    }));
    this.scene.magnification = factor;
    this.scene.moveTo(this.frame);
  }

  _cubicPath(cubic) {
    const [a, b, c, d] = [0, 2, 4, 6].map((k) => this.screen([cubic[k], cubic[k + 1]]));
    this.context.moveTo(...a);
    this.context.bezierCurveTo(...b, ...c, ...d);
  }

  _plainBeams(cubics) {
    this.scene.parts.forEach((part, number) => {
      this._stroke(seriesColour(number), 3.5, () => cubics.forEach((cubic, b) => {
        if (this.scene.raw.beams[b][0] === part) {
          this._cubicPath(cubic);
        }
      }));
    });
  }

  // Beams in pieces, each in the colour of the section force at its middle; pieces of one colour are drawn at once.
  _coloured(cubics, field, limit) {
    const pieces = cubics.length > 100 ? PIECES / 2 : PIECES;
    const paths = Array.from({ length: BINS }, () => []);
    cubics.forEach((cubic, b) => {
      const ends = field.length === cubics.length ? [b, b] : [2 * b, 2 * b + 1]; // one value an element, or two
      const [first, last] = ends.map((column) => field[column][this.frame]);
      let from = this.screen([cubic[0], cubic[1]]);
      for (let p = 0; p < pieces; p += 1) {
        const to = this.screen(alongCubic(cubic, (p + 1) / pieces));
        const value = first + (last - first) * (p + 0.5) / pieces;
        paths[binOf(value, limit)].push(from, to);
        from = to;
      }
    });
    const context = this.context;
    paths.forEach((points, bin) => {
      if (points.length) {
        this._stroke(fieldColour(bin), 4.5, () => {
          for (let k = 0; k < points.length; k += 2) {
            context.moveTo(...points[k]);
            context.lineTo(...points[k + 1]);
          }
        });
      }
    });
  }

  _joint(point) {
    const context = this.context;
    const at = this.scene.point(point.at);
    const [px, py] = this.screen(at);
    if (point.ground) {
      this._keepFree([[px - 12, py + 16], [px + 8, py + 16]]);
      this._stroke(colour("muted"), 1.5, () => {
        context.moveTo(px, py);
        context.lineTo(px - 8, py + 13);
        context.lineTo(px + 8, py + 13);
        context.closePath();
        for (let k = -8; k <= 8; k += 4) {
          context.moveTo(px + k, py + 13);
          context.lineTo(px + k - 4, py + 18);
        }
      });
    }
    if (point.kind === "marker" || point.kind === "trace") {
      this._dot(at, 3, colour("trace"));
      return;
    }
    context.fillStyle = colour("panel");
    context.strokeStyle = point.kind === "clearance" ? colour("alert") : colour("text");
    context.lineWidth = (point.kind === "clearance" ? 2.4 : 1.6) * this.small;
    context.beginPath();
    if (point.kind === "prismatic") {
      context.rect(px - 4 * this.small, py - 4 * this.small, 8 * this.small, 8 * this.small);
    } else if (point.kind === "fixed") {
      [[0, -5.5], [5.5, 0], [0, 5.5], [-5.5, 0]].forEach(([dx, dy], k) => (k ? context.lineTo(px + dx, py + dy) : context.moveTo(px + dx, py + dy)));
      context.closePath();
    } else {
      context.arc(px, py, (point.kind === "clearance" ? 6 : 4) * this.small, 0, 2 * Math.PI);
    }
    context.fill();
    context.stroke();
  }

  // Forces on the second bodies of joints; longer arrows than LONGEST times the reference are cut and dashed.
  _forces() {
    const { forced } = this.scene.raw;
    if (!forced || !(this.limits.force > 0)) {
      return;
    }
    forced.forEach((name, j) => {
      const [fx, fy] = [0, 1].map((c) => this.scene.columns.forces[2 * j + c][this.frame]);
      const size = Math.hypot(fx, fy) / this.limits.force;
      const point = this.scene.raw.points.find((one) => one.part === name);
      if (!point || size < 0.03) {
        return;
      }
      const [px, py] = this.screen(this.scene.point(point.at));
      const cut = size > LONGEST;
      const length = ARROW * Math.min(size, LONGEST);
      const angle = Math.atan2(-fy, fx);
      this._arrow(px, py, angle, length, colour("force"), cut ? [5, 4] : []);
    });
  }

  _arrow(px, py, angle, length, style, dash) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const [qx, qy] = [px + length * c, py + length * s];
    const head = Math.min(9, 0.6 * length);
    this._stroke(style, 2, () => {
      this.context.moveTo(px, py);
      this.context.lineTo(qx - head * c, qy - head * s);
    }, dash);
    this.context.fillStyle = style;
    this.context.beginPath();
    this.context.moveTo(qx, qy);
    this.context.lineTo(qx - head * c + 0.45 * head * s, qy - head * s - 0.45 * head * c);
    this.context.lineTo(qx - head * c - 0.45 * head * s, qy - head * s + 0.45 * head * c);
    this.context.fill();
  }

  _keepFree(points) {
    points.slice(1).forEach((point, k) => this.lines.push([points[k], point]));
  }

  // Names of joints away from their middle and from links; joints at one place share a label, a label that overlaps others at all places is left out.
  _names(width) {
    const groups = [];
    this.scene.raw.points.forEach((point) => {
      const [px, py] = this.screen(this.scene.point(point.at));
      const group = groups.find((one) => Math.hypot(one.px - px, one.py - py) < 14);
      if (group) {
        group.names.push(point.part);
      } else {
        groups.push({ px, py, names: [point.part] });
      }
    });
    const middle = groups.reduce((sum, g) => [sum[0] + g.px / groups.length, sum[1] + g.py / groups.length], [0, 0]);
    const taken = [];
    const context = this.context;
    context.font = FONT;
    groups.forEach((group) => {
      const text = group.names.length > 3 ? `${group.names.slice(0, 3).join(", ")}, ...` : group.names.join(", ");
      const wide = context.measureText(text).width;
      const right = group.px >= middle[0] ? group.px + 10 + wide < width : group.px - 10 - wide < 0;
      const sides = [group.px + 10, group.px - 10 - wide];
      const heights = [group.py - 12, group.py + 12];
      const across = right ? sides : sides.reverse();
      const along = group.py <= middle[1] ? heights : heights.reverse();
      const places = [[across[0], along[0]], [across[0], along[1]], [across[1], along[0]], [across[1], along[1]],
        ...[-18, 18, 28, -42, 42].map((dy) => group.py + dy).map((y) => [group.px - wide / 2, y])];
      const free = ([x, y]) => x >= 0 && x + wide <= width
        && !taken.some((box) => x < box[1] + 8 && x + wide > box[0] - 8 && Math.abs(y - box[2]) < 14);
      const near = this.lines.filter(([[ax, ay], [bx, by]]) => Math.max(ax, bx) > group.px - wide - 12
        && Math.min(ax, bx) < group.px + wide + 12 && Math.max(ay, by) > group.py - 50 && Math.min(ay, by) < group.py + 50);
      const hidden = ([x, y]) => near.filter((line) => meets(line, x - 1, x + wide + 1, y - 7, y + 7)).length;
      const cost = (k) => 10 * hidden(places[k]) + k - (this.placeOf[text] === k ? 2 : 0); // a place is kept while it is good
      const open = [...places.keys()].filter((k) => free(places[k]));
      if (!open.length) {
        return;
      }
      const costs = open.map(cost);
      const chosen = open[costs.indexOf(Math.min(...costs))];
      this.placeOf[text] = chosen;
      const [x, y] = places[chosen];
      taken.push([x, x + wide, y]);
      this._label(text, x, y);
    });
    this.labels = taken;
  }

  _label(text, x, y) {
    const context = this.context;
    context.font = FONT;
    context.textBaseline = "middle";
    context.lineWidth = 3;
    context.strokeStyle = colour("panel");
    context.strokeText(text, x, y);
    context.fillStyle = colour("text");
    context.fillText(text, x, y);
  }

  _symbol(symbol) {
    const context = this.context;
    const style = colour("muted");
    if (symbol.kind === "circle") {
      const [px, py] = this.screen(this.scene.point(symbol.at));
      const [qx, qy] = this.screen(this.scene.point([symbol.at[0], symbol.at[1] + symbol.radius, symbol.at[2]]));
      this._stroke(style, 1.4, () => {
        context.arc(px, py, Math.hypot(qx - px, qy - py), 0, 2 * Math.PI);
        context.moveTo(px, py);
        context.lineTo(qx, qy);
      });
    } else if (symbol.kind === "force") {
      const turn = symbol.turns ? this.scene.angle[symbol.at[0]] : 0;
      const angle = turn + Math.atan2(symbol.direction[1], symbol.direction[0]);
      const [px, py] = this.screen(this.scene.point(symbol.at));
      this._arrow(px - 46 * Math.cos(angle), py + 46 * Math.sin(angle), -angle, 46, colour("load"), []);
    } else {
      const ends = [symbol.first, symbol.second].map((at) => this.screen(this.scene.point(at)));
      const dash = symbol.kind === "cable" ? [5, 4] : [];
      this._stroke(style, symbol.kind === "rod" ? 2.2 : 1.4, () => strut(context, symbol.kind, ends), dash);
    }
  }
}

// Whether a line between two points of the screen meets a box.
function meets([[ax, ay], [bx, by]], x0, x1, y0, y1) {
  let [from, to] = [0, 1];
  [[ax, bx - ax, x0, x1], [ay, by - ay, y0, y1]].forEach(([start, way, low, high]) => {
    if (way) {
      const [p, q] = [(low - start) / way, (high - start) / way];
      [from, to] = [Math.max(from, Math.min(p, q)), Math.min(to, Math.max(p, q))];
    } else if (start < low || start > high) {
      to = -1;
    }
  });
  return from <= to;
}

// Spring, damper, or straight line between two points of the screen.
function strut(context, kind, [[ax, ay], [bx, by]]) {
  const length = Math.hypot(bx - ax, by - ay) || 1;
  const [c, s] = [(bx - ax) / length, (by - ay) / length];
  const zigzag = Array.from({ length: 6 }, (_, k) => [0.15 + 0.7 * (k + 0.5) / 6, k % 2 ? -8 : 8]);
  const shapes = {
    spring: [[[0, 0], [0.15, 0], ...zigzag, [0.85, 0], [1, 0]]],
    damper: [[[0, 0], [0.5, 0]], [[0.5, 6], [0.5, -6]], [[0.35, 8], [0.65, 8], [0.65, -8], [0.35, -8]], [[0.65, 0], [1, 0]]],
  };
  (shapes[kind] || [[[0, 0], [1, 0]]]).forEach((line) => line.forEach(([along, across], k) => {
    const [px, py] = [ax + along * (bx - ax) - across * s, ay + along * (by - ay) + across * c];
    if (k) {
      context.lineTo(px, py);
    } else {
      context.moveTo(px, py);
    }
  }));
}

function binOf(value, limit) {
  const middle = (BINS - 1) / 2;
  return Math.round(middle + middle * Math.max(-1, Math.min(1, value / limit)));
}

// Colours of section forces: blue below zero, red above, grey about zero.
let fieldColours = [];
function fieldColour(bin) {
  if (!fieldColours.length) {
    fieldColours = Array.from({ length: BINS }, (_, k) => {
      const share = k / (BINS - 1);
      return share < 0.5 ? between("low", "zero", 2 * share) : between("zero", "high", 2 * share - 1);
    });
  }
  return fieldColours[bin];
}

// Colours of the stress of meshes: those of positive section forces, in finer steps.
let stressColours = [];
function stressColour(level) {
  if (!stressColours.length) {
    stressColours = Array.from({ length: LEVELS + 1 }, (_, k) => between("zero", "high", k / LEVELS));
  }
  return stressColours[level];
}

function between(first, last, part) {
  const [from, to] = [first, last].map((name) => colour(name).match(/\w\w/g).map((x) => parseInt(x, 16)));
  return `rgb(${from.map((c, i) => Math.round(c + (to[i] - c) * part)).join(",")})`;
}
onTheme(() => {
  fieldColours = [];
  stressColours = [];
});
