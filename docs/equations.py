"""Equations of the site: MathML without scripts, numbered by their labels, so that docstrings can cite the numbers.

An equation stands in a page as `$$ ... $$ (2.3)`. Its label is its number, on the site and wherever it is cited.
Browsers draw MathML themselves, so that the site needs neither a network nor scripts for its formulas.
"""

import re
from pathlib import Path

from api_docstrings import converted
from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.domains.math import MathDomain
from sphinx.errors import ExtensionError
from sphinx.util import logging

LOGGER = logging.getLogger(__name__)
THEORY = Path(__file__).with_name("theory")
LABEL = re.compile(r"^\$\$ \((\d+\.\d+)\)$", re.MULTILINE)
"""End of an equation in a page, with its number."""

MENTION = re.compile(r"(?<![\w`])\((\d+\.\d+)\)")
"""Number of an equation in a text."""

ANCHOR = re.compile(r'^<a id="([\w-]+)"></a>$', re.MULTILINE)
"""Target of links in a page that is read without the site, too."""

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


def mathml(node: nodes.Node, text: str, *, as_block: bool = False) -> str:
    """MathML of a formula; a formula that cannot be translated is a warning with the place of `node`."""
    try:
        return tex2mathml(text, as_block=as_block)
    except MathError as error:
        LOGGER.warning("formula %r: %s", text, error, location=node)
        return ""


def visit_math(self, node: nodes.math) -> None:
    """Formula within a line; one that begins with an exponent, as in `mm$^2$`, gets an empty base."""
    text = node.astext()
    self.body.append(mathml(node, "{}" + text if text.startswith(("^", "_")) else text))
    raise nodes.SkipNode


def visit_displaymath(self, node: nodes.math_block) -> None:
    """Equation of its own line, with its number at the right."""
    self.body.append(self.starttag(node, "div", CLASS="math"))
    if node["number"]:
        self.body.append(f'<span class="eqno">({node["label"]})')
        self.add_permalink_ref(node, "Link to this equation")
        self.body.append("</span>")
    self.body.append(mathml(node, node.astext(), as_block=True) + "</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, object]:
    """Registration with Sphinx."""
    app.add_domain(LabelledEquations, override=True)
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    app.connect("source-read", link_page)
    app.connect("autodoc-process-docstring", process_docstring)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
