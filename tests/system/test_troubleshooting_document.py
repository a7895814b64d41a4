"""The headings of docs/troubleshooting.md are messages of the program, word for word."""

import re
from pathlib import Path
from types import CodeType

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "troubleshooting.md").read_text("utf-8")
HEADINGS = re.findall(r"^### (.+)$", PAGE, re.MULTILINE)


def messages():
    """Return all strings of the program except docstrings, one per line, with f-strings in pieces."""
    # The compiler's constants take a fraction of the time of a walk through the syntax.
    found = [
        compile(path.read_text("utf-8"), str(path), "exec", dont_inherit=True, optimize=2)
        for path in (ROOT / "grabbergui").rglob("*.py")
    ]
    texts = []
    while found:
        constant = found.pop()
        if isinstance(constant, CodeType):
            found += constant.co_consts
        elif isinstance(constant, (tuple, frozenset)):
            found += constant
        elif isinstance(constant, str):
            texts.append(constant)
    return "\n".join(texts)


def test_every_heading_is_a_message_of_the_program():
    """One test: each worker that runs a part of it parses the whole program."""
    pieces = {heading: [piece.strip() for piece in heading.split("…")] for heading in HEADINGS}
    assert not [heading for heading in HEADINGS if all(len(piece) <= 10 for piece in pieces[heading])]
    texts = messages()
    assert not [heading for heading in HEADINGS if any(piece not in texts for piece in pieces[heading])]


def test_the_page_has_headings():
    assert len(HEADINGS) > 20
