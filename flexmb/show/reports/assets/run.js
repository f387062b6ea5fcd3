// Page of a run: clock, picture, plots and journals together.
async function startRun() {
  const stats = { ticks: 0 };
  const [times] = await columnsOf(DATA.signals.time);
  const clock = new Clock(times, stats);
  const plots = await Plots.of(DATA.signals, clock);
  const journals = (await Promise.all(DATA.journals.map((raw) => Journal.of(raw)))).filter(Boolean);
  const host = document.getElementById("plots");
  DATA.signals.panels.forEach((names) => plots.add(host, names));
  fillMore(plots, host);
  const energies = DATA.signals.names.filter((name) => name.startsWith("energy.") && !/turned_over$/.test(name) && plots.varies(name));
  const energyHost = document.getElementById("energy-plots");
  if (energyHost && energies.length) {
    plots.add(energyHost, energies, { height: 240, removable: false });
  }
  const drawJournals = () => journals.forEach((journal) => journal.draw(clock.frame));
  clock.onChange(() => {
    plots.show();
    drawJournals();
  });
  onTheme(drawJournals);
  new ResizeObserver(drawJournals).observe(document.body);
  let picture = null;
  if (DATA.scene) {
    picture = new Picture(document.getElementById("picture"), await Scene.of(DATA.scene));
    new Controls(clock, picture);
  }
  document.querySelectorAll("button.go[data-time]").forEach((button) => button.addEventListener("click", () => {
    clock.play(false);
    clock.goTo(Number(button.dataset.time));
    (document.getElementById("picture") || host).scrollIntoView({ block: "nearest" });
  }));
  const running = markRunning(clock);
  clock.onChange(running);
  running();
  drawJournals();
  document.documentElement.dataset.ready = "run";
  window.flexmbReport = { clock, plots, picture, stats };
}

// Function that marks the contact intervals of the present time in their tables.
function markRunning(clock) {
  const rows = [...document.querySelectorAll("button.go[data-end]")].map((button) => {
    const end = Number(button.dataset.end);
    return { row: button.closest("tr"), start: Number(button.dataset.time), end: Number.isNaN(end) ? Infinity : end };
  });
  return () => {
    const time = clock.times[clock.frame];
    rows.forEach((one) => {
      const now = time >= one.start && time <= one.end;
      if (now !== one.now) {
        one.now = now;
        one.row.classList.toggle("chosen", now);
      }
    });
  };
}

// Signals that have no plot yet, by part, in the choice of further plots.
function fillMore(plots, host) {
  const more = document.getElementById("more-signals");
  const parts = {};
  plots.raw.names.forEach((name) => {
    const part = name.slice(0, name.lastIndexOf("."));
    (parts[part] = parts[part] || []).push(name);
  });
  Object.entries(parts).forEach(([part, names]) => {
    more.append(element("optgroup", { label: part }, ...names.map((name) => element("option", { value: name }, name))));
  });
  more.addEventListener("change", () => {
    if (more.value) {
      const panel = plots.add(host, [more.value]);
      more.value = "";
      panel.box.scrollIntoView({ block: "nearest" });
    }
  });
}

startRun();
