"""Pages of reports as a reader sees them, by code that their writer does not share, and a long chain to be shown."""

import base64
import json
import re
import zlib
from html.parser import HTMLParser

import numpy as np

import flexmb as fm

OVERLAPS = """() => {
  const chosen = 'h1, h2, h3, button, select, input, output, canvas, p, label, table, dl > div, nav a, .area, .keys';
  const visible = (e) => e.checkVisibility() && !e.closest('.visually-hidden');
  const all = [...document.querySelectorAll(chosen)].filter(visible);
  const box = (e) => e.getBoundingClientRect();
  const clips = (e) => e !== document.documentElement && getComputedStyle(e).overflowY !== 'visible';
  const clipped = (e) => (e ? [...(clips(e) ? [box(e)] : []), ...clipped(e.parentElement)] : []);
  const found = [];
  all.forEach((a, i) => all.slice(i + 1).forEach((b) => {
    if (a.contains(b) || b.contains(a) || a.closest('label') === b || b.closest('label') === a) return;
    const [p, q] = [box(a), box(b)];
    const limits = [...clipped(a.parentElement), ...clipped(b.parentElement)];
    const left = Math.max(p.left, q.left, ...limits.map((l) => l.left));
    const right = Math.min(p.right, q.right, ...limits.map((l) => l.right));
    const top = Math.max(p.top, q.top, ...limits.map((l) => l.top));
    const bottom = Math.min(p.bottom, q.bottom, ...limits.map((l) => l.bottom));
    if (right - left > 1.5 && bottom - top > 1.5) {
      found.push([a, b].map((e) => `${e.tagName}#${e.id}.${e.className} ${e.textContent.slice(0, 30)}`).join(' over '));
    }
  }));
  return found;
}"""
"""Pairs of elements with text or controls that cover one another."""

CUT = """() => [...document.querySelectorAll('h1, h2, h3, button, p, label, output, dd, dt, caption, nav a')]
  .filter((e) => e.checkVisibility() && !e.closest('.visually-hidden, .scroll'))
  .filter((e) => { const b = e.getBoundingClientRect();
    return b.left < -1 || b.right > innerWidth + 1 || e.scrollWidth > e.clientWidth + 2 && e.clientWidth > 0; })
  .map((e) => `${e.tagName}#${e.id} ${e.textContent.slice(0, 40)}`)"""
"""Elements that leave the page, or whose text leaves them."""

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")

STEEL = fm.Material(young=2e11, density=7850.0, poisson=0.3)


class Page(HTMLParser):
    """A page as a reader of HTML sees it: elements with their attributes, visible text, data."""

    def __init__(self, path):
        super().__init__()
        self.source = path.read_text(encoding="utf-8")
        self.path, self.elements, self.pieces, self._inside = path, [], [], []
        self.feed(self.source)
        (data,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', self.source, re.DOTALL)
        self.data = json.loads(data)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._inside.append(tag)

    def handle_endtag(self, tag):
        if self._inside and self._inside[-1] == tag:
            self._inside.pop()

    def handle_data(self, data):
        if not self._inside:
            self.pieces.append(data)

    @property
    def text(self):
        return "\n".join(self.pieces)

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


def unpacked(packed):
    """Columns (n, m) of packed numbers."""
    n, size = packed["n"], packed["size"]
    raw = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), dtype=np.uint8)
    if size == 8:
        return raw.reshape(8, n).T.copy().view("<f8").reshape(n)
    planes = raw.reshape(size, packed["m"], n).astype(np.uint64)
    steps = sum(plane << np.uint64(8 * k) for k, plane in enumerate(planes))
    whole = np.cumsum(steps, axis=1) % 2 ** (32 if size == 4 else 8 * size)
    if size == 4:
        return whole.astype(np.uint32).view(np.float32).T
    return (np.array(packed["low"])[:, None] + np.array(packed["step"])[:, None] * whole).T


def chain(links, elements):
    """A hanging chain of flexible links, held at its left end."""
    parts, before = [], fm.GROUND
    section = fm.Rectangle(width=0.01, height=0.004)
    for k in range(links):
        ends = (0.1 * k, 0.0), (0.1 * (k + 1), 0.0)
        link = fm.FlexibleLink(f"link{k}", *ends, section=section, material=STEEL, elements=elements, damping=1e-4)
        parts += [link, fm.Revolute(f"J{k}", before, link, at=ends[0])]
        before = link
    return fm.Mechanism("chain", parts, gravity=(0.0, -9.81))


def soft_engine(speed=60.0):
    """A slider-crank with a connecting rod of a soft mesh, which bends; and the rod."""
    soft = fm.Material(young=2e8, density=7850.0, poisson=0.3)
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.014, size=0.008)
    rod = fm.PlaneBody("rod", mesh, start=(0.05, 0.0), end=(0.17, 0.0), thickness=0.01, material=soft)
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.05, 0.0), mass=0.3, inertia=1e-4)
    slider = fm.RigidBody("slider", at=(0.17, 0.0), mass=0.1, inertia=1e-4)
    parts = [
        crank,
        rod,
        slider,
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("A", crank, rod, at=(0.05, 0.0)),
        fm.Revolute("B", rod, slider, at=(0.17, 0.0)),
        fm.Prismatic("guide", fm.GROUND, slider, along=(1.0, 0.0)),
        fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(speed)),
    ]
    return fm.Mechanism("engine", parts), rod
