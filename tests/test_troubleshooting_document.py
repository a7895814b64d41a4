"""The headings of docs/troubleshooting.md are what the program says, word for word."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "troubleshooting.md").read_text("utf-8")
HEADINGS = re.findall(r"^### (.+)$", PAGE, re.MULTILINE)


@cache
def said():
    """Every text in the program's code but its docstrings, one to a line; the pieces of f-strings apart."""
    texts = []
    for path in (ROOT / "grabbergui").rglob("*.py"):
        nodes = list(ast.walk(ast.parse(path.read_text("utf-8"))))
        docstrings = {node.value for node in nodes if isinstance(node, ast.Expr)}
        constants = [node for node in nodes if isinstance(node, ast.Constant) and node not in docstrings]
        texts += [node.value for node in constants if isinstance(node.value, str)]
    return "\n".join(texts)


@pytest.mark.parametrize("heading", HEADINGS)
def test_a_heading_is_what_the_program_says(heading):
    pieces = [piece.strip() for piece in heading.split("…")]
    assert any(len(piece) > 10 for piece in pieces)
    assert not [piece for piece in pieces if piece not in said()]


def test_the_page_has_headings():
    assert len(HEADINGS) > 20
