// Mesh of a flexible body: a rigid motion carries its points and the shapes of its deformation, whose factors change.
class Mesh {
  static async of(raw) {
    const names = ["points", "weights", "shapes", "stress"];
    const columns = await Promise.all(names.map((name) => (raw[name] ? columnsOf(raw[name]) : [])));
    return new Mesh(raw, ...columns);
  }

  constructor(raw, [px, py], weights, shapes, stress) {
    Object.assign(this, { raw, px, py, weights, shapes, stress, x: new Float64Array(px.length), y: new Float64Array(px.length) });
  }

  // Place of a point at a frame, by the pose of the rigid motion.
  place(i, [x, y, angle], k, magnification) {
    const m = this.px.length;
    let [u, v] = [this.px[i], this.py[i]];
    this.shapes.forEach((shape, j) => {
      const factor = magnification * this.weights[j][k];
      u += factor * shape[i];
      v += factor * shape[m + i];
    });
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return [x + c * u - s * v, y + s * u + c * v];
  }

  moveTo([x, y, angle], k, magnification) {
    const m = this.px.length;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const factors = this.weights.map((column) => magnification * column[k]);
    for (let i = 0; i < m; i += 1) {
      let u = this.px[i];
      let v = this.py[i];
      for (let j = 0; j < factors.length; j += 1) {
        u += factors[j] * this.shapes[j][i];
        v += factors[j] * this.shapes[j][m + i];
      }
      this.x[i] = x + c * u - s * v;
      this.y[i] = y + s * u + c * v;
    }
  }

  // First places in raw.triangles of the triangles of each level, by the mean stress of their corners at a frame; low levels first.
  inColours(k, levelOf) {
    const found = new Map();
    const { triangles } = this.raw;
    for (let t = 0; t < triangles.length; t += 3) {
      const level = levelOf((this.stress[triangles[t]][k] + this.stress[triangles[t + 1]][k] + this.stress[triangles[t + 2]][k]) / 3);
      if (!found.has(level)) {
        found.set(level, []);
      }
      found.get(level).push(t);
    }
    return new Map([...found].sort(([a], [b]) => a - b));
  }
}
