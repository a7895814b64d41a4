"""Writes JSON, for commands, files and networks: the one place, so that all of it is JSON (RFC 8259).

Python writes NaN and Infinity into JSON, which other programs refuse; here they are null.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any


def to_json(
    content: object,
    *,
    indent: int | None = None,
    compact: bool = False,
    ascii_only: bool = True,
    default: Callable[[Any], Any] | None = None,
) -> str:
    """Return plain data as JSON. Raises TypeError for anything else that `default` does not make plain.

    `compact`: without blanks. `ascii_only`: other characters are escaped.
    """
    separators = (",", ":") if compact else None

    def written(plain: object) -> str:
        return json.dumps(
            plain,
            allow_nan=False,
            indent=indent,
            separators=separators,
            ensure_ascii=ascii_only,
            default=default,
        )

    try:
        return written(content)
    except ValueError:  # a number that JSON does not have
        return written(json.loads(json.dumps(content, default=default), parse_constant=lambda _: None))
