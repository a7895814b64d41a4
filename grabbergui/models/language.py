"""Sentences of the models in the user's language, though no model knows a toolkit.

Whoever shows them sets a translator; until then they are as they are written. `scripts/translations` finds
the calls of `translate` as it finds Qt's own.
"""

from __future__ import annotations

import re
from collections.abc import Callable

Translator = Callable[[str, str], str]
"""Context and text to the text in another language."""


def _as_written(context: str, text: str) -> str:
    return text


_translator: Translator = _as_written
_decimal_point = "."

_POINT = re.compile(r"(?<=\d)\.(?=\d)")


def translate(context: str, text: str) -> str:
    """Return a text in the user's language; its placeholders are filled afterwards. Any thread."""
    return _translator(context, text)


def localized(text: str) -> str:
    """Write numbers in a text with the user's decimal point: `0,5` in Spanish. Any thread."""
    return text if _decimal_point == "." else _POINT.sub(_decimal_point, text)


def counted(count: int, one: str, many: str) -> str:
    """Return the text of one thing or, with its number in place of {0}, that of several. Any thread.

    Both texts are translated already. Qt's numerus forms would need a file for English, too.
    """
    return one if count == 1 else many.format(count)


def set_translator(translator: Translator | None, decimal_point: str = ".") -> None:
    """Translate from now on, numbers with that decimal point; None leaves texts as they are written."""
    global _translator, _decimal_point
    _translator = translator or _as_written
    _decimal_point = decimal_point


def is_translated() -> bool:
    """Return whether the user's language is another one than texts are written in."""
    return _translator is not _as_written
