// Player of a run alone, in a cell of a notebook.
async function startCell() {
  const [times] = await columnsOf(DATA.time);
  const clock = new Clock(times, { ticks: 0 });
  const picture = new Picture(document.getElementById("picture"), await Scene.of(DATA.scene));
  new Controls(clock, picture);
  document.documentElement.dataset.ready = "cell";
  window.flexmbCell = { clock, picture };
}

startCell();
