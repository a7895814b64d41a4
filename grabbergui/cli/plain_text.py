"""What is printed where a terminal or a pipe knows no Unicode: the nearest that it knows."""

from __future__ import annotations

import codecs
import io
from typing import TextIO

_SPELLED = str.maketrans({"×": "x", "…": "...", "→": "->", "–": "-", "±": "+-", "µ": "u", "°": " deg"})
_NAME = "grabbergui.spelled"


def spell_out(stream: TextIO | None) -> None:
    """Let a stream write what its encoding lacks in other letters instead of failing."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors=_NAME)


def _spelled(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end].translate(_SPELLED)
    return text.encode("ascii", "replace").decode("ascii"), error.end


codecs.register_error(_NAME, _spelled)
