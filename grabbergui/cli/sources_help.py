"""The end of `grabbergui --help`: the kinds of source and their options."""

from __future__ import annotations

from grabbergui.cli import wrapped
from grabbergui.core.uri import option_rows
from grabbergui.sources import SourceKind


def sources_help() -> str:
    """Return the kinds of source and their options as plain text, as wide as the terminal."""
    forms = [form for kind in SourceKind for form in kind.forms]
    width = max(len(uri) for uri, _ in forms) + 4
    lines = [wrapped("sources (`grabbergui list` shows those in reach):")]
    lines += [
        wrapped(meaning.replace("`", ""), " " * width, f"  {uri:{width - 2}}") for uri, meaning in forms
    ]
    lines += ["", wrapped("options of a source, behind a question mark and joined by &:")]
    for kind in SourceKind:
        options = [f"{row.name}={row.form}" for row in option_rows(kind.options)]
        if options:
            lines.append(wrapped(" ".join(options), " " * 9, f"  {kind.value + ':':7}"))
    return "\n".join(lines)
