// Journals in their bearings, with the clearance enlarged.
class Journal {
  static async of(raw) {
    const canvas = [...document.querySelectorAll("canvas.journal")].find((one) => one.dataset.joint === raw.joint);
    const [now, path] = await Promise.all([columnsOf(raw.now), columnsOf(raw.path)]);
    return canvas ? new Journal(raw, canvas, now, path) : null;
  }

  constructor(raw, canvas, now, path) {
    Object.assign(this, { raw, canvas, now, path });
    this.largest = largeValue([now[3]], 0.98);
    this.readout = element("p", { class: "readout" });
    canvas.after(this.readout);
  }

  draw(k) {
    const { context, width, height } = fitted(this.canvas);
    const half = Math.min(width, height) / 2;
    const bearing = 0.86 * half;
    const play = 0.38 * half; // clearance on the screen
    const { clearance, touching } = this.raw;
    const to = (ex, ey) => [width / 2 + ex / clearance * play, height / 2 - ey / clearance * play];
    const [ex, ey, depth, force] = this.now.map((column) => column[k]);
    const [jx, jy] = to(ex, ey);
    context.clearRect(0, 0, width, height);
    const circle = (x, y, radius) => {
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
    };
    context.lineWidth = 0.1 * half;
    context.strokeStyle = colour("faint");
    circle(width / 2, height / 2, bearing + 0.05 * half);
    context.stroke();
    context.fillStyle = colour("journal");
    circle(jx, jy, bearing - play);
    context.fill();
    context.lineWidth = 1;
    context.strokeStyle = colour("muted");
    context.setLineDash([4, 4]);
    circle(width / 2, height / 2, play);
    context.stroke();
    context.setLineDash([]);
    this._path(context, to, touching);
    const size = Math.hypot(ex, ey);
    if (depth > 0 && size > 0) {
      const [c, s] = [ex / size, -ey / size];
      context.fillStyle = colour("alert");
      circle(width / 2 + bearing * c, height / 2 + bearing * s, 5);
      context.fill();
      const length = this.largest > 0 ? 0.5 * half * Math.min(force / this.largest, 1.3) : 0;
      context.strokeStyle = colour("force");
      context.lineWidth = 2.5;
      context.beginPath();
      context.moveTo(width / 2 + bearing * c, height / 2 + bearing * s);
      context.lineTo(width / 2 + (bearing - length) * c, height / 2 + (bearing - length) * s);
      context.stroke();
    }
    context.fillStyle = colour("text");
    circle(jx, jy, 3.5);
    context.fill();
    const state = depth > 0 ? `in contact, depth ${shown(depth, 3)} m, normal force ${shown(force, 4)} N` : "free";
    this.readout.textContent = `e = (${shown(ex, 4)}, ${shown(ey, 4)}) m, ${state}`;
  }

  // Path of the centre, in contact and in flight.
  _path(context, to, touching) {
    [0, 1].forEach((wanted) => {
      context.strokeStyle = colour(wanted ? "series-1" : "trace");
      context.lineWidth = wanted ? 1.6 : 0.8;
      context.globalAlpha = wanted ? 0.9 : 0.6;
      context.beginPath();
      for (let i = 1; i < touching.length; i += 1) {
        if ((touching[i] === "1" && touching[i - 1] === "1") === (wanted === 1)) {
          context.moveTo(...to(this.path[0][i - 1], this.path[1][i - 1]));
          context.lineTo(...to(this.path[0][i], this.path[1][i]));
        }
      }
      context.stroke();
    });
    context.globalAlpha = 1;
  }
}
