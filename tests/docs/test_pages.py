"""Code of the pages runs as it stands and prints what the pages show; links lead somewhere; equations are cited."""

import contextlib
import inspect
import io
import re
import sys
import types
from pathlib import Path
from typing import NamedTuple

import pytest
from cases import slow_where
from public_names import NAMESPACES, PUBLIC

import flexmb as fm
from flexmb.arguments import Checked
from flexmb.cli.command_line import main

ROOT = Path(__file__).resolve().parents[2]
OWN_TEST = {"own_constraint.md"}
"""Pages whose code has a test of its own."""

FENCE = re.compile(r"^(<!-- slow: [^>]+ -->\n)?```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?")
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)|!\[[^\]]*\]\(([^)\s]+)\)")
CITATION = re.compile(r"\((\d+\.\d+)\)(?:\s+to\s+\((\d+\.\d+)\))?")


class Block(NamedTuple):
    """A block of code of a page: language, text, and whether it is too slow for every run."""

    language: str
    text: str
    slow: bool


def blocks(path):
    """Blocks of a page in their order."""
    return [Block(m[2], m[3], bool(m[1])) for m in FENCE.finditer(path.read_text(encoding="utf-8"))]


def pages():
    """Pages of the documentation, without those that Sphinx makes from docstrings."""
    found = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [path for path in found if (ROOT / "docs" / "api") not in path.parents]


def pages_with_code():
    """Pages with Python or shell blocks."""
    found = [page for page in pages() if page.name not in OWN_TEST]
    return [page for page in found if any(block.language in ("python", "sh") for block in blocks(page))]


def named(page):
    return page.relative_to(ROOT).as_posix()


def same_text(printed, shown):
    """Whether two texts agree but for spaces, and numbers within 1e-3 of each other."""
    words = [" ".join(NUMBER.sub("#", text).split()) for text in (printed, shown)]
    numbers = [[float(x) for x in NUMBER.findall(text)] for text in (printed, shown)]
    return words[0] == words[1] and numbers[0] == pytest.approx(numbers[1], rel=1e-3, abs=1e-12)


def run_python(text, number, names, folder):
    """Run a block in a file of its own, so that kernels have their source; return what it prints."""
    file = folder / f"block_{number}.py"
    file.write_text(text, encoding="utf-8")
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(text, str(file), "exec"), names)
    return output.getvalue()


def run_shell(text):
    """Run the commands `flexmb ...` of a block; others (installation, make) must at least be known."""
    for line in text.splitlines():
        command = line.partition("#")[0].split()
        if command[:1] == ["flexmb"] and "--out" in command and command[-1] == "out/demo":
            assert f"$(BIN)/{' '.join(command)}" in (ROOT / "Makefile").read_text(encoding="utf-8")  # `make demo`
        elif command[:1] == ["flexmb"]:
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                assert main(command[1:]) == 0, line
        elif command[:1] == ["make"]:
            assert f"\n{command[1]}:" in (ROOT / "Makefile").read_text(encoding="utf-8"), line
        else:
            known = (["pip", "install"], ["python3", "-m"], [".", ".venv/bin/activate"])
            assert not command or command[:2] in known, line


def module_of(page):
    """A module for the code of a page, so that its classes can be pickled."""
    module = types.ModuleType(f"code_of_{page.stem}")
    sys.modules[module.__name__] = module
    return vars(module)


def run_page(page, folder, *, slow):
    names = module_of(page)
    printed = ""
    for number, block in enumerate(blocks(page)):
        if block.slow and not slow:
            printed = None
        elif block.language == "python":
            printed = run_python(block.text, number, names, folder)
        elif block.language == "sh":
            run_shell(block.text)
            printed = None
        elif block.language == "text" and printed is not None:
            assert same_text(printed, block.text), f"printed:\n{printed}\nthe page shows:\n{block.text}"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    yield tmp_path
    plt.close("all")


LONG = ("design", "chaos", "controllers", "files", "joints", "plane_bodies")  # pages that take more than a second


@pytest.mark.parametrize(
    "page",
    slow_where(lambda n: n.stem in LONG, pages_with_code()),
    ids=named,
)
def test_code_of_a_page(page, folder):
    run_page(page, folder, slow=False)


@pytest.mark.slow
@pytest.mark.parametrize("page", [p for p in pages_with_code() if any(b.slow for b in blocks(p))], ids=named)
def test_slow_code_of_a_page(page, folder):
    run_page(page, folder, slow=True)


@pytest.mark.parametrize(
    ("printed", "shown", "same"),
    [
        ("peak 1234.5 N", "peak  1234.6 N", True),
        ("peak 1234.5 N", "peak 1243.5 N", False),
        ("chaotic", "periodic-1", False),
        ("1.0 2.0", "1.0", False),
    ],
)
def test_texts_are_compared_with_their_numbers(printed, shown, same):
    assert same_text(printed, shown) is same


# Links.


def slug(title):
    """Anchor of a heading, as Sphinx and the usual viewers of Markdown make it."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title.strip()).lower()
    return re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", plain))


def without_code(text):
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)


def anchors(path):
    text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {slug(title) for title in titles} | set(re.findall(r'<a id="([\w-]+)">', text))


def broken_links(path):
    """Links of a page that lead to no file, to no anchor, or are no address."""
    for match in LINK.finditer(without_code(path.read_text(encoding="utf-8"))):
        target = match[1] or match[2]
        if re.match(r"[a-z]+:", target):
            if not re.fullmatch(r"https?://[\w.-]+(/[^\s]*)?|mailto:\S+@\S+", target):
                yield target
            continue
        file, _, anchor = target.partition("#")
        where = (path.parent / file).resolve() if file else path
        if where.is_relative_to(ROOT / "docs" / "api"):
            continue  # made by Sphinx, which checks links to it
        if not where.exists() or (anchor and anchor not in anchors(where)):
            yield target


@pytest.mark.parametrize("page", [*pages(), ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md"], ids=named)
def test_links_lead_somewhere(page):
    assert not list(broken_links(page))


def test_broken_links_are_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Title\n[a](none.md) [b](#title) [c](#other) ![d](no.png) [e](http:/x)", encoding="utf-8")
    assert list(broken_links(page)) == ["none.md", "#other", "no.png", "http:/x"]


def test_every_page_is_in_a_table_of_contents():
    listed = {ROOT / "README.md", ROOT / "docs" / "index.md"}
    for page in pages():
        for block in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            entries = [line for line in block.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{entry}.md").resolve() for entry in entries}
    assert not set(pages()) - listed


# Equations.


@pytest.fixture(scope="module")
def labels():
    return equations()[0]


def equations():
    """Pages by the numbers of their equations, and the numbers of mere steps of a derivation."""
    found, steps = {}, set()
    for page in sorted((ROOT / "docs" / "theory").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        for number in re.findall(r"^\$\$ \((\d+\.\d+)\)$", text, re.MULTILINE):
            assert number not in found, f"equation ({number}) stands twice"
            found[number] = page.name
        steps |= set(re.findall(r"^\$\$ \((\d+\.\d+)\)\n\n<!-- derivation -->$", text, re.MULTILINE))
    return found, steps


def citations(text):
    """Numbers and pages that the docstrings of a source cite."""
    for sentence in re.findall(r"Equations? ([^;:]*?) of\s+docs/theory/(\w+\.md)", text):
        yield from ((number, sentence[1]) for number in numbers_of(sentence[0]))
    for more in re.findall(r"; \w+: (\([^;:]*?\)) of\s+docs/theory/(\w+\.md)", text):
        yield from ((number, more[1]) for number in numbers_of(more[0]))


def numbers_of(text):
    """Numbers of equations: (2.1), (2.3) to (2.5)."""
    for first, last in CITATION.findall(text):
        chapter, begin = first.split(".")
        end = last.split(".")[1] if last else begin
        yield from (f"{chapter}.{k}" for k in range(int(begin), int(end) + 1))


def test_every_citation_is_an_equation(cited_sources, labels):
    cited = [(source.path, *found) for source in cited_sources for found in citations(source.text)]
    assert len(cited) > 50
    assert not [entry for entry in cited if labels.get(entry[1]) != entry[2]]
    mentions = sum(source.text.count("docs/theory/") for source in cited_sources)
    sentences = r"\) of\s+docs/theory/\w+\.md"
    assert mentions == sum(len(re.findall(sentences, source.text)) for source in cited_sources)


def test_every_equation_is_cited_or_a_step(cited_sources):
    found, steps = equations()
    cited = {number for source in cited_sources for number, _ in citations(source.text)}
    assert not set(found) - cited - steps
    assert steps <= set(found)


def test_chapters_count_their_equations(labels):
    """Numbers of a page are 1, 2, 3, ... of its chapter, in their order."""
    for page in set(labels.values()):
        numbers = [number.split(".") for number, where in labels.items() if where == page]
        assert [int(k) for _, k in numbers] == list(range(1, len(numbers) + 1))
        assert len({chapter for chapter, _ in numbers}) == 1
        title = (ROOT / "docs" / "theory" / page).read_text(encoding="utf-8").splitlines()[0]
        assert title.startswith(f"# {numbers[0][0]} ")


def formulas():
    """Formulas of all pages, (page, TeX)."""
    for page in pages():
        text = without_code(page.read_text(encoding="utf-8"))
        yield from ((page, tex) for tex in re.findall(r"\$\$\n(.*?)\n\$\$", text, re.DOTALL))
        inline = re.sub(r"\$\$.*?\$\$", "", text, flags=re.DOTALL)
        yield from ((page, tex) for tex in re.findall(r"\$([^$]+)\$", inline))


def test_formulas_have_known_commands():
    parser = pytest.importorskip("docutils.utils.math.latex2mathml", reason="needs the requirements of the site")
    known = 0
    for page, tex in formulas():
        parser.tex2mathml("{}" + tex if tex.startswith(("^", "_")) else tex)
        known += page.parent.name == "theory"
    assert known > 150


# API.


@pytest.fixture(scope="module")
def api_pages():
    before = list(sys.path)
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        import api_pages
    finally:
        sys.path[:] = before
    return api_pages


def test_every_public_name_is_on_one_page(api_pages):
    made = [name for sections in api_pages.pages().values() for names in sections.values() for name in names]
    assert len(made) == len(set(made))
    things = [id(PUBLIC[name]) for name in made]
    assert len(things) == len(set(things))
    assert set(things) == {id(thing) for thing in PUBLIC.values()}


def test_no_name_at_the_top_is_left_over(api_pages):
    assert "Others" not in api_pages.pages()["fm"]
    assert set(api_pages.pages()) == {"fm", *NAMESPACES}


def test_pages_of_the_api_document_their_names(api_pages):
    for page, sections in api_pages.pages().items():
        text = api_pages.text_of(page, sections)
        for names in sections.values():
            for name in names:
                assert (
                    len(re.findall(rf"(?:autoclass|autofunction|py:data):: flexmb\.{re.escape(name)}$", text, re.M))
                    == 1
                )


def test_docstrings_become_text_of_sphinx(api_pages):
    doc = "A law N*x.\n\nParameters\n----------\na, b : numbers of |x|, see `name_`.\n    More.\n\nNotes\n-----\nText."
    lines = "\n".join(api_pages.converted(doc.splitlines()))
    assert "A law N\\*x." in lines
    assert "``a, b``\n    numbers of \\|x\\|, see ``name_``." in lines
    assert ".. rubric:: Notes" in lines


def test_signatures_are_those_of_the_constructors():
    """Classes of checked arguments do not show the (*args, **keywords) of their common base."""
    classes = [thing for thing in PUBLIC.values() if inspect.isclass(thing) and issubclass(thing, Checked)]
    assert len(classes) > 80
    for cls in classes:
        shown = list(inspect.signature(cls).parameters)
        assert shown == list(inspect.signature(cls.__init__).parameters)[1:], cls
    assert list(inspect.signature(fm.Force).parameters)[:4] == ["name", "body", "at", "force"]


def test_the_gallery_begins_with_all_examples():
    text = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    index = text.partition("\n## ")[0]
    assert re.findall(r'pictures/gallery/(\w+)\.png"', index) == re.findall(r"\]\(pictures/gallery/(\w+)\.png\)", text)


# The site.


@pytest.mark.slow
def test_the_site_is_built_without_warnings(tmp_path):
    pytest.importorskip("sphinx", reason="needs the requirements of the site")
    for package in ("furo", "myst_parser", "sphinx-mathjax-offline"):
        pytest.importorskip(package, reason="needs the requirements of the site")
    from sphinx.cmd.build import build_main

    options = ["-n", "-W", "--keep-going", "-q", "-b", "html", "-d", str(tmp_path / "cache")]
    assert build_main([*options, str(ROOT / "docs"), str(tmp_path / "site")]) == 0
    text = (tmp_path / "site" / "theory" / "beam.html").read_text(encoding="utf-8")
    assert "(2.12)" in text
    loads = re.sub(r"<[^>]+>", "", (tmp_path / "site" / "api" / "loads.html").read_text(encoding="utf-8"))
    assert re.search(r"Force\(name,\s+body,\s+at,\s+force,", loads)
    assert "[source]" in loads
    outside = [
        (page.name, address)
        for page in (tmp_path / "site").rglob("*.html")
        for address in re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="(https?:[^"]*)"', page.read_text("utf-8"))
    ]
    assert not outside, "the site loads something from a network"
