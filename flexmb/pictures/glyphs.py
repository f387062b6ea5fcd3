"""Texts of figures in characters that a font of the machine has; other characters as their escapes."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.text import Text


EMPTY = "Last Resort"
"""Beginning of the name of a font of matplotlib that has a box for each script, and no characters."""


def make_drawable(texts: Iterable[Text]) -> None:
    r"""Set the fonts of texts by their characters; characters without a font become escapes such as \u66f2."""
    from matplotlib.font_manager import findfont

    for text in texts:
        words = text.get_text()
        if words.isascii():
            continue
        own = findfont(text.get_fontproperties())
        fonts = {c: _family(own, c) for c in words}
        text.set_text("".join(_escaped(c) if fonts[c] is None else c for c in words))
        others = [name for name in dict.fromkeys(fonts.values()) if name and name not in text.get_fontfamily()]
        text.set_fontfamily([*text.get_fontfamily(), *others])


def _escaped(character: str) -> str:
    return character.encode("ascii", "backslashreplace").decode()


@cache
def _family(own: str, character: str) -> str | None:
    """Family of a font that has a character: "" for the file `own`, None where no font has it."""
    from matplotlib.font_manager import fontManager

    if character.isspace() or _has(own, character):
        return ""
    fonts = [font for font in fontManager.ttflist if font.style == "normal" and not font.name.startswith(EMPTY)]
    return next((font.name for font in fonts if _has(font.fname, character)), None)


def _has(file: str, character: str) -> bool:
    """Whether a file is a font that can be drawn and has a character."""
    from matplotlib.font_manager import get_font

    try:
        return get_font(file).get_char_index(ord(character)) > 0
    except (OSError, RuntimeError):  # fonts of coloured pictures, and damaged files
        return False
