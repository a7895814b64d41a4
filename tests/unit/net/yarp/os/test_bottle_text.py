"""Bottles as lines of text: where a line and a bottle end, how long they may be, and what that costs."""

import time
from contextlib import suppress

import pytest

from every_case import every_case
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.framing import (
    CONTINUED_LINES,
    LINE_LIMIT,
    LineReader,
    TextBottle,
)
from grabbergui.net.yarp.os.values import (
    MAX_ITEMS,
)
from patience import attempts

HOSTILE_LINES = {
    "lists in lists around a long text": "(" * 60 + "a " * (MAX_ITEMS - 100) + ")" * 60,
    "900 kB of lists in lists": "(" * 60 + "a " * 450_000 + ")" * 60,
    "brackets in a word": "a" + "(" * (LINE_LIMIT // 2 - 1) + ")" * (LINE_LIMIT // 2),
    "empty lists": "() " * MAX_ITEMS,
    "numbers": "1.5 " * MAX_ITEMS,
    "a blob": "{" + "1 " * (MAX_ITEMS - 1) + "}",
    "a blob of long numbers": "{" + "-1.5e9 " * (MAX_ITEMS - 1) + "}",
    "a blob without an end": "{" + "1 " * (MAX_ITEMS - 1),
    "a blob of too many": "{" + "1 " * (LINE_LIMIT // 2 - 1) + "}",
    "escapes": '"' + "\\a" * (LINE_LIMIT // 2 - 1) + '"',
    "one number": "1" * LINE_LIMIT,
}


@every_case("line", HOSTILE_LINES.values(), ids=HOSTILE_LINES)
def test_no_line_takes_long(line):
    # 2 to 20 ms on a desktop. One that is read again at every level takes many seconds.
    for watch in attempts(0.5, clock=time.thread_time):
        with watch, suppress(RemoteProtocolError):
            Bottle.from_text(line)


def test_a_bottle_over_many_lines_takes_no_longer_than_on_one():
    lines = ["("] + ["a " * 200] * 40 + [")"]
    for watch in attempts(0.5, clock=time.thread_time):
        with watch:
            joined = TextBottle()
            (text,) = [text for line in lines if (text := joined.add(line)) is not None]
            (found,) = Bottle.from_text(text)
    assert found == ["a"] * 8000


@pytest.mark.parametrize(
    ("data", "lines", "rest"),
    [
        (b"a \r\nb\t\n", ["a ", "b\t"], b""),
        (b"/MAX\n/MAX\r\n", ["/MAX", "/MAX"], b""),
        (b"/\xe9\xff\r\n", ["/\udce9\udcff"], b""),
        (b"0123456789\n0123456789", ["0123456789"], b"0123456789"),
        (b"\nshort\n0123456789", ["", "short"], b"0123456789"),
    ],
)
def test_lines_as_they_were_written_up_to_the_limit(data, lines, rest):
    for step in (1, len(data)):
        reader, buffer, found = LineReader(10), bytearray(), []
        for start in range(0, len(data), step):
            buffer += data[start : start + step]
            while (line := reader.take(buffer)) is not None:
                found.append(line)
        assert found == lines and buffer == rest


@pytest.mark.parametrize("end", ["", "\n", "\nb"])
def test_a_line_longer_than_the_limit_is_refused(end):
    with pytest.raises(RemoteProtocolError, match=f"more than {LINE_LIMIT} bytes"):
        LineReader().take(bytearray(b"a" * (LINE_LIMIT + 1) + end.encode()))


HALF = "a" * (LINE_LIMIT // 2 - 1)


@pytest.mark.parametrize(
    ("lines", "text"),
    [
        (["(a", "b)"], "(a\nb)"),
        (["{1", "2}"], "{1\n2}"),
        (['"a', 'b"'], '"a\nb"'),
        (["((a", "b)", ")"], "((a\nb)\n)"),
        (["a \\", "b"], "a b"),
        (['"( {" a'], '"( {" a'),
        ([r"\( \" \{"], r"\( \" \{"),
        ([r"\) (", ")"], "\\) (\n)"),
        ([r'"\"("'], r'"\"("'),
        (["a\\\\", "(b"], "a\\(b"),  # YARP 3.12 reads "a(b" from it
        (["(1) a\\\\", "(b"], "(1) a\\(b"),
        (["(" + HALF, HALF + ")"], None),
        (["a" * (LINE_LIMIT - 1) + "\\", ""], "a" * (LINE_LIMIT - 1)),
        (["(", *[""] * (CONTINUED_LINES - 2), ")"], "(" + "\n" * (CONTINUED_LINES - 1) + ")"),
    ],
    ids=[
        "list", "blob", "string", "lists", "backslash", "brackets in quotes", "escapes", "escape and list",
        "escape in quotes", "escape over the end", "escape over the end after a list", "longest",
        "longest continued", "most lines",
    ],
)  # fmt: skip
def test_a_bottle_over_several_lines(lines, text):
    bottle = TextBottle()
    assert [bottle.add(line) for line in lines[:-1]] == [None] * (len(lines) - 1)
    assert bottle.add(lines[-1]) == (text or "\n".join(lines))


@pytest.mark.parametrize(
    "lines",
    [["(" + HALF, HALF + "a)"], ["a" * LINE_LIMIT + "\\"], ["(", *[""] * (CONTINUED_LINES - 1)]],
    ids=["size", "size of one line", "lines"],
)
def test_a_bottle_beyond_the_limits_is_refused(lines):
    bottle = TextBottle()
    assert [bottle.add(line) for line in lines[:-1]] == [None] * (len(lines) - 1)
    with pytest.raises(RemoteProtocolError, match="without an end"):
        bottle.add(lines[-1])


@pytest.mark.parametrize(
    ("text", "items"),
    [
        ("f(a b) (c (d)) {1 (2) x 300}", ["f(a b)", ["c", ["d"]], bytes((1, 0, 0, 44))]),
        ("{} { } {0,255, 256 10} {010 0x10 -1}", [b"", b"", bytes((0, 255, 0, 10)), bytes((8, 16, 255))]),
        (r"a\ b \( c", ["a b", "(", "c"]),
        ("f() g{} h", ["f()", "g{}", "h"]),
        ('f(a (b "c) d")) e', ['f(a (b "c) d"))', "e"]),
        ('a"b c"d ",(" ()', ['a"b c"d', ",(", []]),
    ],
)
def test_brackets_and_quotes_in_words(text, items):
    assert Bottle.from_text(text) == items


@every_case("text", ["(a", "a)", "(a}", "{(1}", "f(a", "f(a})", '"a', 'a"', '(")', ")("])
def test_brackets_and_quotes_that_do_not_match(text):
    with pytest.raises(RemoteProtocolError, match="do not match"):
        Bottle.from_text(text)
