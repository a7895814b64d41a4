"""What people read is printable, and nothing is printed past the one writer."""

import ast
import json
import sys
import unicodedata
from functools import partial
from pathlib import Path

import pytest

import grabbergui
from grabbergui.core import visible_text
from grabbergui.core.features import MOST_TITLE, Category, EnumEntry, FeatureDescription, FeatureKind
from grabbergui.core.identity import MOST_NAME, DeviceInfo
from grabbergui.core.visible_text import print_json, print_line, print_lines, print_note, shortened, visible
from grabbergui.models.features.number_text import MOST_UNIT, unit_text
from grabbergui.models.messages import MOST_TEXT, UserMessage

PACKAGE = Path(grabbergui.__file__).parent
TO_MACHINES = {"setup/completion.py", "ui/run/standalone.py"}
"""Files that write to stdout for another program: a shell's script, the window of a servo loop."""


@pytest.mark.parametrize(
    ("text", "seen"),
    [
        ("plain text, é → 日本 😀", "plain text, é → 日本 😀"),
        ("two\u2009words", "two\u2009words"),
        ("\x1b]0;title\x07", r"\x1b]0;title\x07"),
        ("a\x08b\x7f", r"a\x08b\x7f"),
        ("line\r\nnext\tcolumn", r"line\r\nnext\tcolumn"),
        ("\x9b31m\x85\u2028\u2029", r"\x9b31m\x85\u2028\u2029"),
        ("\u202egpj.exe\u2066\u200b\ufeff\u00ad", r"\u202egpj.exe\u2066\u200b\ufeff\xad"),
        ("\u3164\u115f\U000e0041\udcff\ue000", r"\u3164\u115f\U000e0041\udcff\ue000"),
    ],
)
def test_what_a_terminal_would_obey_or_hide_is_spelled_out(text, seen):
    assert visible(text) == seen


def test_every_character_is_printable_or_a_space():
    odd = [sign for sign in map(chr, range(sys.maxunicode + 1)) if not visible(sign).isprintable()]
    assert {unicodedata.category(sign) for sign in odd} == {"Zs"}


def test_each_call_prints_one_line(capsys):
    print_line("a\nb")
    print_line("c\r", error=True)
    print_lines(["d", "e\x1b"])
    print_json({"f": "g\x1b\u202e"})
    print_note("h\x07")
    out, err = capsys.readouterr()
    assert out.splitlines() == [r"a\nb", "d", r"e\x1b", r'{"f": "g\u001b\u202e"}']
    assert json.loads(out.splitlines()[-1]) == {"f": "g\x1b\u202e"}
    assert err == "c\\r\n\r\x1b[Kh\\x07"


def test_a_closed_stream_is_no_error(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdout", None)
    print_line("lost")
    assert capsys.readouterr() == ("", "")


def test_an_uncaught_error_does_not_control_the_terminal(capsys):
    try:
        raise ValueError("a\x1b]0;title\x07\nb")
    except ValueError as error:
        visible_text.print_traceback(type(error), error, error.__traceback__)
    assert capsys.readouterr().err.splitlines()[-2:] == [r"ValueError: a\x1b]0;title\x07", "b"]


def bypassing(source):
    """Return the lines of Python that print, or write to a standard stream, by themselves."""
    if not any(word in source for word in ("print", "stdout", "stderr")):
        return []
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print":
            found.append(node.lineno)
        if isinstance(node, ast.Attribute) and node.attr in ("write", "writelines", "buffer"):
            stream = node.value
            if isinstance(stream, ast.Attribute) and stream.attr in ("stdout", "stderr"):
                found.append(node.lineno)
    return sorted(found)


def test_nothing_is_printed_past_the_writer():
    assert bypassing("print(1)\nsys.stdout.write('a')\nsys.stderr.buffer\nprint_line(1)") == [1, 2, 3]
    own = TO_MACHINES | {"core/visible_text.py"}
    found = {
        f"{file.relative_to(PACKAGE)}:{line}"
        for file in PACKAGE.rglob("*.py")
        if file.relative_to(PACKAGE).as_posix() not in own
        for line in bypassing(file.read_text("utf-8"))
    }
    assert not found, "print with grabbergui.core.visible_text, so that text from outside is harmless"


def test_display_names_have_an_end():
    assert shortened("abc", 3) == "abc" and shortened("abcd", 3) == "ab…"
    for made in (Category, EnumEntry, partial(FeatureDescription, kind=FeatureKind.FLOAT)):
        longest = made(name="Name", display_name="x" * MOST_TITLE)
        assert longest.title == longest.display_name
        assert made(name="Name", display_name="x" * (MOST_TITLE + 1)).title == "x" * (MOST_TITLE - 1) + "…"
    assert len(DeviceInfo("sim:", user_name="x" * 1000).title) == MOST_NAME
    assert len(UserMessage("x" * 10_000).sentence) == MOST_TEXT
    assert len(unit_text("x" * 1000)) == MOST_UNIT and unit_text("us") == "µs"
