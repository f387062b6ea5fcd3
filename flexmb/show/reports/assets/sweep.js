// Page of a bifurcation diagram: points by verdict, a line at the chosen value, links to reports of runs.
async function startSweep() {
  const values = (await columnsOf(DATA.values))[0];
  const choice = document.getElementById("signal");
  const canvas = document.getElementById("diagram");
  const told = document.getElementById("chosen");
  const rows = [...document.querySelectorAll("#values tbody tr")];
  let chosen = -1;

  const choose = (k, open) => {
    chosen = Math.min(Math.max(k, 0), DATA.rows.length - 1);
    const row = DATA.rows[chosen];
    diagram.chosen = values[row.place];
    diagram.draw();
    rows.forEach((one, i) => one.classList.toggle("chosen", i === chosen));
    const exponent = row.exponent === null ? "" : `, exponent ${shown(row.exponent)} ${DATA.unit_of_exponent}`;
    const text = `${DATA.parameter} = ${shown(values[row.place], 6)} ${DATA.unit}: ${row.verdict || "failed"}${exponent}`;
    told.replaceChildren(text);
    if (row.link) {
      told.append(" ", element("a", { href: row.link, id: "link" }, "report of this run"));
    }
    if (open && row.link) {
      location.href = row.link;
    }
  };

  const diagram = new Diagram(canvas, { onPick: (k) => choose(k, true) });
  const show = async () => {
    const signal = DATA.signals.find((one) => one.name === choice.value);
    const columns = await columnsOf(signal.points); // one column a row of the table
    const groups = new Map();
    DATA.rows.forEach((row, k) => {
      const key = `${row.entry} ${row.direction}`;
      if (!groups.has(key)) {
        const style = () => (row.colour ? row.colour : colour("text"));
        groups.set(key, { x: [], y: [], tags: [], style, marker: row.direction });
      }
      const group = groups.get(key);
      columns[k].forEach((y) => {
        group.x.push(values[row.place]);
        group.y.push(y);
        group.tags.push(k);
      });
    });
    diagram.show([...groups.values()], [], [DATA.parameter, signal.name], [DATA.unit, signal.unit]);
  };
  fillChoice(choice, DATA.signals.map((one) => one.name), DATA.signals[0].name);
  choice.addEventListener("change", show);
  document.getElementById("fit").addEventListener("click", () => diagram.fit());
  canvas.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity };
    if (event.key in steps) {
      choose(chosen + steps[event.key], false);
      event.preventDefault();
    } else if (event.key === "Enter" && chosen >= 0) {
      choose(chosen, true);
    }
  });
  Object.entries(DATA.legend).forEach(([entry, style]) => {
    const swatch = element("span", { class: "swatch" });
    swatch.style.background = style || colour("text");
    document.getElementById("legend").append(element("span", {}, swatch, entry));
  });
  await show();
  document.documentElement.dataset.ready = "sweep";
  window.flexmbReport = { diagram, choose };
}

startSweep();
