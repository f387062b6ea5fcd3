// Places of the mechanism at a frame: frames carry nodes, nodes carry shapes; displacements can be magnified.
class Scene {
  static async of(raw) {
    const names = ["frames", "displacements", "moment", "axial", "stress", "forces"];
    const columns = await Promise.all(names.map((name) => (raw[name] ? columnsOf(raw[name]) : [])));
    const meshes = await Promise.all(raw.meshes.map((mesh) => Mesh.of(mesh)));
    return new Scene(raw, Object.fromEntries(names.map((name, k) => [name, columns[k]])), meshes);
  }

  constructor(raw, columns, meshes) {
    Object.assign(this, { raw, columns, meshes, magnification: 1 });
    this.count = raw.frames.n;
    this.x = new Float64Array(raw.nodes.length);
    this.y = new Float64Array(raw.nodes.length);
    this.angle = new Float64Array(raw.nodes.length);
    this.parts = raw.parts;
    this.numberOf = Object.fromEntries(this.parts.map((part, k) => [part, k]));
  }

  // Pose x, y, angle of a node at a frame, with magnified displacements.
  node(i, k) {
    const [frame, rx, ry, turn, own] = this.raw.nodes[i];
    if (frame < 0) {
      return [0, 0, 0];
    }
    const [x, y, angle] = this.pose(frame, k);
    if (own < 0) {
      return [x, y, angle];
    }
    const [dx, dy, da] = [0, 1, 2].map((c) => this.magnification * this.columns.displacements[3 * own + c][k]);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const [px, py] = [rx + dx, ry + dy];
    return [x + c * px - s * py, y + s * px + c * py, angle + turn + da];
  }

  moveTo(k) {
    for (let i = 0; i < this.raw.nodes.length; i += 1) {
      [this.x[i], this.y[i], this.angle[i]] = this.node(i, k);
    }
    this.meshes.forEach((mesh) => mesh.moveTo(this.pose(mesh.raw.frame, k), k, this.magnification));
  }

  // Place x, y, angle of a frame.
  pose(frame, k) {
    return [0, 1, 2].map((c) => this.columns.frames[3 * frame + c][k]);
  }

  // Point of a place [node, x, y] at the present frame.
  point([i, px, py]) {
    const [c, s] = [Math.cos(this.angle[i]), Math.sin(this.angle[i])];
    return [this.x[i] + c * px - s * py, this.y[i] + s * px + c * py];
  }

  // Control points of the cubic of a beam between two poses.
  static cubic(beam, [xa, ya, ta], [xb, yb, tb]) {
    const [, , , length, startAngle, endAngle, first = 0, last = 0] = beam;
    const [dx, dy] = [xb - xa, yb - ya];
    const chord = Math.hypot(dx, dy) || 1e-300;
    const direction = Math.atan2(dy, dx);
    const [a, b] = [turned(ta + startAngle - direction), turned(tb + endAngle - direction)];
    const sheared = first * a + last * b; // the axis leans less than its sections
    const [u, v] = [(a - sheared) * length / 3, (b - sheared) * length / 3];
    const [c, s] = [dx / chord, dy / chord];
    return [xa, ya, xa + dx / 3 - s * u, ya + dy / 3 + c * u, xb - dx / 3 + s * v, yb - dy / 3 - c * v, xb, yb];
  }

  beam(b) {
    const beam = this.raw.beams[b];
    const [, i, j] = beam;
    const first = [this.x[i], this.y[i], this.angle[i]];
    return Scene.cubic(beam, first, [this.x[j], this.y[j], this.angle[j]]);
  }

  // Path of a picked point over all frames.
  path(pick) {
    const points = [];
    for (let k = 0; k < this.count; k += 1) {
      if (pick.beam !== undefined) {
        const beam = this.raw.beams[pick.beam];
        points.push(alongCubic(Scene.cubic(beam, this.node(beam[1], k), this.node(beam[2], k)), pick.along));
      } else if (pick.mesh !== undefined) {
        const mesh = this.meshes[pick.mesh];
        points.push(mesh.place(pick.number, this.pose(mesh.raw.frame, k), k, this.magnification));
      } else {
        const [i, px, py] = pick.place;
        const [x, y, angle] = this.node(i, k);
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        points.push([x + c * px - s * py, y + s * px + c * py]);
      }
    }
    return points;
  }

  // Point of a part that is nearest to (x, y) at the present frame, with its distance.
  nearest(x, y) {
    let best = { distance: Infinity };
    for (const shape of this.raw.rigid) {
      for (const line of shape.lines) {
        for (let k = 0; k < Math.max(line.length - 1, 1); k += 1) {
          const a = this.point([shape.node, ...line[k]]);
          const b = this.point([shape.node, ...line[Math.min(k + 1, line.length - 1)]]);
          const [distance, along] = distanceTo(x, y, a, b);
          if (distance < best.distance) {
            const end = line[Math.min(k + 1, line.length - 1)];
            const place = [0, 1].map((c) => line[k][c] + along * (end[c] - line[k][c]));
            best = { distance, part: shape.part, place: [shape.node, ...place] };
          }
        }
      }
    }
    this.raw.beams.forEach((beam, b) => {
      const cubic = this.beam(b);
      for (let k = 0; k <= 16; k += 1) {
        const [px, py] = alongCubic(cubic, k / 16);
        const distance = Math.hypot(px - x, py - y);
        if (distance < best.distance) {
          best = { distance, part: beam[0], beam: b, along: k / 16 };
        }
      }
    });
    this.meshes.forEach((mesh, m) => mesh.raw.loops.flat().forEach((number) => {
      const distance = Math.hypot(mesh.x[number] - x, mesh.y[number] - y);
      if (distance < best.distance) {
        best = { distance, part: mesh.raw.part, mesh: m, number };
      }
    }));
    return best;
  }

  // Limits [x0, x1, y0, y1] of all points over the run.
  limits() {
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    const add = ([x, y]) => {
      box[0] = Math.min(box[0], x);
      box[1] = Math.max(box[1], x);
      box[2] = Math.min(box[2], y);
      box[3] = Math.max(box[3], y);
    };
    const step = Math.max(1, Math.floor(this.count / 150));
    for (let k = 0; k < this.count; k += step) {
      this.moveTo(k);
      this.raw.rigid.forEach((shape) => shape.lines.flat().forEach((p) => add(this.point([shape.node, ...p]))));
      this.raw.beams.forEach((beam) => [beam[1], beam[2]].forEach((i) => add([this.x[i], this.y[i]])));
      this.meshes.forEach((mesh) => mesh.raw.loops.flat().forEach((i) => add([mesh.x[i], mesh.y[i]])));
      this.raw.points.forEach((point) => add(this.point(point.at)));
      this.raw.symbols.forEach((s) => [s.first, s.second, s.at].filter(Boolean).forEach((at) => {
        const [x, y] = this.point(at);
        const r = s.radius || 0;
        add([x - r, y - r]);
        add([x + r, y + r]);
      }));
    }
    return Number.isFinite(box[0]) ? box : [-1, 1, -1, 1];
  }

  // Factor that makes the largest displacement some tenth of the size: 1, 3, 10, ...
  suggestedMagnification(size) {
    let largest = Math.max(0, ...this.raw.meshes.map((mesh) => mesh.largest));
    this.columns.displacements.forEach((column, c) => {
      if (c % 3 < 2) {
        column.forEach((value) => { largest = Math.max(largest, Math.abs(value)); });
      }
    });
    const factors = [10000, 3000, 1000, 300, 100, 30, 10, 3];
    return factors.find((factor) => factor * largest < 0.12 * size) || 1;
  }
}

// An angle in [-pi, pi].
function turned(angle) {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

function alongCubic([x0, y0, x1, y1, x2, y2, x3, y3], t) {
  const s = 1 - t;
  const [a, b, c, d] = [s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t];
  return [a * x0 + b * x1 + c * x2 + d * x3, a * y0 + b * y1 + c * y2 + d * y3];
}

// Distance of a point from a segment, and the nearest place on it from 0 to 1.
function distanceTo(x, y, [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const square = dx * dx + dy * dy;
  const along = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
  return [Math.hypot(ax + along * dx - x, ay + along * dy - y), along];
}

// Absolute value that a fraction of all numbers of some columns does not exceed.
function largeValue(columns, fraction) {
  const sizes = [];
  const total = columns.reduce((sum, column) => sum + column.length, 0);
  const stride = Math.max(1, Math.floor(total / 200000));
  columns.forEach((column) => {
    for (let k = 0; k < column.length; k += stride) {
      sizes.push(Math.abs(column[k]));
    }
  });
  sizes.sort((a, b) => a - b);
  return sizes.length ? sizes[Math.min(sizes.length - 1, Math.floor(fraction * sizes.length))] : 0;
}
