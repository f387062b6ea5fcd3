"""Docstrings of flexmb as text of Sphinx: sections of numpydoc whose entries are "name : description"."""

import re

UNDERLINE = re.compile(r"^-{3,}$")
ENTRY = re.compile(r"^(?P<names>[^\s:][^:]*?)(?: : (?P<text>.*))?$")
CODE = re.compile(r"(`[^`]*`)")
SPECIAL = re.compile(r"([*|\\]|_(?=\W|$))")
"""Characters that Sphinx would take for emphasis, substitutions or references."""


def plain(line: str) -> str:
    """Line in which code is marked as such and no other character has a meaning."""
    pieces = CODE.split(line)
    pieces[::2] = [SPECIAL.sub(r"\\\1", piece) for piece in pieces[::2]]
    pieces[1::2] = [f"`{piece}`" for piece in pieces[1::2]]
    return "".join(pieces)


def entries(lines: list[str]) -> list[str]:
    """Definition list of the entries of a section."""
    out: list[str] = []
    for line in lines:
        entry = ENTRY.match(line)
        if entry and line[0] != " ":
            text = entry["text"]
            out += ["", f"``{entry['names']}``", *([f"    {plain(text)}"] if text else [])]
        else:
            out.append(plain(line))
    return out


def sections(lines: list[str]) -> list[tuple[str, list[str]]]:
    """Titles and lines of the sections; the text before the first one has the title ""."""
    found: list[tuple[str, list[str]]] = [("", [])]
    for k, line in enumerate(lines):
        if UNDERLINE.match(line):
            continue
        if k + 1 < len(lines) and UNDERLINE.match(lines[k + 1]) and line.strip():
            found.append((line.strip(), []))
        else:
            found[-1][1].append(line)
    return found


def prose(lines: list[str]) -> list[str]:
    """Paragraphs; lines of an interactive example stay as they are, and indented lines keep their breaks."""
    out: list[str] = []
    example = False
    for line in lines:
        example = line.startswith(">>>") or (example and bool(line.strip()))
        indented = line.startswith(" ") and not example
        if out and out[-1].strip() and indented and not out[-1].startswith((" ", "- ")):
            out.append("")
        if out and out[-1].startswith("    ") and line.strip() and not line.startswith(" "):
            out.append("")
        out.append(line if example else plain(line))
    return out


def converted(lines: list[str]) -> list[str]:
    """Lines of a docstring as reStructuredText."""
    out: list[str] = []
    for title, text in sections(lines):
        if not title:
            out += prose(text)
        else:
            out += [
                "",
                f".. rubric:: {title}",
                "",
                *(prose(text) if title in {"Notes", "Examples"} else entries(text)),
                "",
            ]
    return out
