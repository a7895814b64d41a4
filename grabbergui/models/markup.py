"""Rich text that this program wrote, with text from outside escaped in it.

Names, tooltips, units, errors and file names come from cameras, peers and folders. The window shows only a
`Markup` as rich text (`ui.shown_text`), and `markup` makes one of such texts.
"""

from __future__ import annotations

import html
from collections.abc import Iterable


class Markup(str):
    """Text in the HTML subset of Qt."""

    __slots__ = ()


def markup(template: str, *arguments: object) -> Markup:
    """Fill a template in rich text with `str.format`; texts are escaped, unless they are Markup."""
    return Markup(template.format(*map(_escaped, arguments)))


def joined(parts: Iterable[str], separator: str = "") -> Markup:
    """Join parts; those that are not Markup are escaped. `separator` is rich text."""
    return Markup(separator.join(str(_escaped(part)) for part in parts))


def table(rows: Iterable[tuple[str, str]]) -> Markup:
    """Return a table of names and what they stand for."""
    lines = (markup("<tr><td>{0}&nbsp;&nbsp;</td><td>{1}</td></tr>", name, text) for name, text in rows)
    return markup("<table>{0}</table>", joined(lines))


def _escaped(argument: object) -> object:
    if isinstance(argument, Markup) or not isinstance(argument, str):
        return argument
    return html.escape(argument).replace("\n", "<br>")
