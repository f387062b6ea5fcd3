// Colours of the page: those of the system, light or dark.
const themed = [];
const THEMES = ["system", "light", "dark"];

let colours = new Map(); // asked of the browser once

function colour(name) {
  if (!colours.has(name)) {
    colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  }
  return colours.get(name);
}

// Colours of curves and bodies, by number; after the last one they begin anew.
function seriesNumber(k) {
  return k % Number(colour("series-count"));
}

function seriesColour(k) {
  return colour(`series-${seriesNumber(k)}`);
}

function onTheme(action) {
  themed.push(action);
}

function themeChanged() {
  colours = new Map();
  themed.forEach((action) => action());
}

(function () {
  const button = document.getElementById("theme");
  let chosen = 0;
  button?.addEventListener("click", () => {
    chosen = (chosen + 1) % THEMES.length;
    document.documentElement.dataset.theme = THEMES[chosen];
    button.textContent = `Theme: ${THEMES[chosen]}`;
    themeChanged();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", themeChanged);
})();

// Canvas with sharp lines: sets its pixels to those of the screen and returns its size in CSS pixels.
function fitted(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height };
}
