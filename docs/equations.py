"""Equations of the site: numbered by their labels, so that docstrings can cite the numbers; drawn by a local MathJax.

An equation stands in a page as `$$ ... $$ (2.3)`. Its label is its number, on the site and wherever it is cited.
"""

import importlib.util
import re
from pathlib import Path

from api_docstrings import converted
from sphinx.application import Sphinx
from sphinx.domains.math import MathDomain
from sphinx.errors import ExtensionError
from sphinx.util.fileutil import copy_asset

THEORY = Path(__file__).with_name("theory")
LABEL = re.compile(r"^\$\$ \((\d+\.\d+)\)$", re.MULTILINE)
"""End of an equation in a page, with its number."""

MENTION = re.compile(r"(?<![\w`])\((\d+\.\d+)\)")
"""Number of an equation in a text."""

ANCHOR = re.compile(r'^<a id="([\w-]+)"></a>$', re.MULTILINE)
"""Target of links in a page that is read without the site, too."""


def mathjax() -> Path:
    """File of MathJax in the package that carries it."""
    spec = importlib.util.find_spec("sphinx-mathjax-offline")
    if spec is None or spec.origin is None:
        raise ExtensionError("MathJax is missing; install the requirements of the site with pip install --group docs.")
    return Path(spec.origin).parent / "static" / "mathjax" / "tex-svg.js"


MATHJAX = mathjax()
BLOCK = re.compile(r"(\$\$.*?\$\$ \(\d+\.\d+\)|```.*?```|`[^`\n]*`)", re.DOTALL)
"""Text of a page in which nothing is replaced: equations and code."""


def labels() -> dict[str, str]:
    """Pages by the numbers of their equations, {"2.3": "theory/beam"}; a number that stands twice is an error."""
    found: dict[str, str] = {}
    for page in sorted(THEORY.glob("*.md")):
        for label in LABEL.findall(page.read_text(encoding="utf-8")):
            if label in found:
                raise ExtensionError(f"equation ({label}) stands in {found[label]} and in theory/{page.stem}")
            found[label] = f"theory/{page.stem}"
    return found


class LabelledEquations(MathDomain):
    """Domain of equations whose numbers are their labels."""

    def note_equation(self, docname, labelid, location=None):
        """Registration of an equation under its label."""
        super().note_equation(docname, labelid, location)
        self.equations[labelid] = (docname, labelid)


def linked(text: str, known: dict[str, str], role: str) -> str:
    """Text in which the numbers of known equations have become references; equations and code are left alone."""
    pieces = BLOCK.split(text)
    pieces[::2] = [MENTION.sub(lambda m: role % m[1] if m[1] in known else m[0], piece) for piece in pieces[::2]]
    return "".join(pieces)


def link_page(app: Sphinx, docname: str, content: list[str]) -> None:
    """References in the theory pages, and targets of links in all pages."""
    content[0] = ANCHOR.sub(r"(\1)=", content[0])
    if docname.startswith("theory/"):
        content[0] = linked(content[0], labels(), "{eq}`%s`")


def process_docstring(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Docstrings as reStructuredText, with references where they cite equations of a theory page."""
    lines[:] = converted(lines)
    text = "\n".join(lines)
    if "docs/theory/" in text:
        lines[:] = linked(text, labels(), ":eq:`%s`").split("\n")


def copy_mathjax(app: Sphinx, failure: Exception | None) -> None:
    """MathJax in the folder of the site; one file, which needs neither fonts nor a network."""
    if failure is None and app.builder.format == "html":
        copy_asset(MATHJAX, Path(app.outdir) / "_static")


def setup(app: Sphinx) -> dict[str, object]:
    """Registration with Sphinx."""
    app.add_domain(LabelledEquations, override=True)
    app.config.mathjax_path = MATHJAX.name
    app.connect("build-finished", copy_mathjax)
    app.connect("source-read", link_page)
    app.connect("autodoc-process-docstring", process_docstring)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
