// Page of a fit: measured points and fitted curves, residuals over the noise.
async function startFit() {
  const finite = (list) => list.filter((value) => Number.isFinite(value));
  const diagrams = await Promise.all(DATA.signals.map(async (one, k) => {
    const [time, measured, computed, left] = await columnsOf(one.curves);
    const span = [time[0], time[time.length - 1]];
    const across = (y, dash) => ({ x: span, y: [y, y], style: () => colour("muted"), dash });
    const pieces = (values) => {
      const limits = finite(values).reduce(([low, high], y) => [Math.min(low, y), Math.max(high, y)], [Infinity, -Infinity]);
      return DATA.begins.map((x) => ({ x: [x, x], y: limits, style: () => colour("muted"), dash: [2, 3] }));
    };
    const above = new Diagram(document.getElementById(`fitted-${k}`));
    const points = { x: time, y: measured, style: () => colour("faint"), under: true };
    const curve = { x: time, y: computed, style: () => seriesColour(0), width: 1.6 };
    above.show([points], [curve, ...pieces([...measured, ...computed])], ["time", one.name], ["s", one.unit]);
    const below = new Diagram(document.getElementById(`left-${k}`));
    const band = [across(0), across(2, [6, 4]), across(-2, [6, 4])];
    const rest = { x: time, y: left, style: () => seriesColour(0) };
    below.show([rest], [...band, ...pieces([...left, 2, -2])], ["time", "residual over noise"], ["s", ""]);
    return [above, below];
  }));
  document.documentElement.dataset.ready = "fit";
  window.flexmbReport = { diagrams };
}

startFit();
