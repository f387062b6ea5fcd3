// Page of a study of a motion: section, convergence of the exponents.
async function startChaos() {
  const section = await columnsOf(DATA.section.points);
  const motion = DATA.motion ? await columnsOf(DATA.motion.curves) : [];
  const { names, units } = DATA.section;
  const [across, up] = [document.getElementById("across"), document.getElementById("up")];
  const canvas = document.getElementById("diagram");
  const diagram = new Diagram(canvas);
  const withMotion = document.getElementById("motion");
  const column = (name) => (name === "number" ? Float64Array.from(section[0], (_, k) => DATA.first + k) : section[names.indexOf(name)]);
  const unit = (name) => units[names.indexOf(name)] || "";
  const show = () => {
    const [x, y] = [across.value, up.value];
    const curves = [x, y].map((name) => motion[(DATA.motion ? DATA.motion.names : []).indexOf(name)]);
    const lines = withMotion && withMotion.checked && curves[0] && curves[1]
      ? [{ x: curves[0], y: curves[1], style: () => colour("faint"), width: 0.7 }] : [];
    diagram.equal = x !== "number" && unit(x) === unit(y) && unit(x) === "m";
    diagram.show([{ x: column(x), y: column(y), style: () => colour("series-1") }], lines, [x, y], [unit(x), unit(y)]);
  };
  fillChoice(across, ["number", ...names], DATA.plane[0]);
  fillChoice(up, names, DATA.plane[1]);
  [across, up, withMotion].filter(Boolean).forEach((control) => control.addEventListener("change", show));
  document.getElementById("fit").addEventListener("click", () => diagram.fit());
  show();
  const history = document.getElementById("history");
  let convergence = null;
  if (history) {
    const [times, ...values] = await columnsOf(DATA.history);
    convergence = new Diagram(history);
    const lines = values.map((y, k) => ({ x: times, y, style: () => seriesColour(k), width: 1.4 }));
    convergence.show([], lines, ["t", "exponents"], ["s", DATA.unit]);
  }
  document.documentElement.dataset.ready = "chaos";
  window.flexmbReport = { diagram, convergence };
}

startChaos();
