"""Bottles in memory: the bytes and the text that real YARP has for them, and what must be refused."""

import struct
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os.binary import MAGIC_BASE, decode_name_size, encode_number
from grabbergui.net.yarp.os.bottle import Bottle, Properties
from grabbergui.net.yarp.os.bottle_text import Nesting
from grabbergui.net.yarp.os.carrier import TCP
from grabbergui.net.yarp.os.framing import (
    BottleScanner,
    Receiver,
)
from grabbergui.net.yarp.os.values import (
    MAX_DEPTH,
    MAX_ITEMS,
    Dialect,
    Float32,
    Int8,
    Int16,
    Int64,
    Vocab,
    Vocab64,
    word,
)
from yarp_transcripts import read, streams

TCP_GREETING = encode_number(MAGIC_BASE + TCP.code)


def bodies(name):
    for conversation in streams(name, TCP_GREETING):
        start = 12 + decode_name_size(conversation.client[8:12])
        for message in Receiver().feed(conversation.client[start:]):
            if message.code == "D":
                yield bytes(message.body)


@pytest.mark.parametrize(
    ("name", "dialect"),
    [("bottle_types_tcp_312", Dialect.YARP3), ("bottle_types_tcp_40", Dialect.YARP4)],
)
def test_real_bottles_are_read_and_written_byte_for_byte(name, dialect):
    messages = list(bodies(name))
    assert len(messages) >= 5
    for message in messages:
        assert Bottle.decode(message, dialect).encode(dialect) == message
        assert Bottle.decode(message).encode(dialect) == message, "the dialect is found out"


def test_real_bottles_print_as_yarp_prints_them():
    name = "bottle_types_tcp_312"
    from yarp_transcripts import DATA

    printed = [
        line[4:] for line in (DATA / f"{name}.txt").read_text().splitlines() if line.startswith("#   ")
    ]
    ours = [Bottle.decode(message).to_text() for message in bodies(name)]
    assert set(printed) <= set(ours)


def test_text_carriers_bottles_are_read_as_the_binary_ones():
    conversation = next(c for c in read("bottle_types_text_312") if c.client.startswith(b"CONNECT /types"))
    lines = conversation.client.decode().split("\r\n")
    texts = [body for command, body in pairwise(lines) if command == "D" and body != "D"]
    binary = {Bottle.decode(message).to_text() for message in bodies("bottle_types_tcp_312")}
    assert len(texts) > 10
    assert {Bottle.from_text(text).to_text() for text in texts} <= binary


items = st.recursive(
    st.one_of(
        st.integers(-(2**31), 2**31 - 1),
        st.integers(2**31, 2**63 - 1),
        st.integers(-128, 127).map(Int8),
        st.integers(-(2**15), 2**15 - 1).map(Int16),
        st.integers(-(2**63), 2**63 - 1).map(Int64),
        st.floats(allow_nan=False),
        st.floats(width=32, allow_nan=False).map(Float32),
        st.text(),
        st.binary(max_size=40),
        st.text("abcXYZ09_", max_size=4).map(Vocab),
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=5).map(kind) for kind in (Bottle, Properties)),
    max_leaves=20,
)
bottles = st.lists(items, max_size=8).map(Bottle)


def typed(item):
    return (type(item), [typed(part) for part in item]) if isinstance(item, list) else (type(item), item)


class Word(str):
    pass


class Number(int):
    pass


def wire_form(item, dialect):
    """Type code and value of a Bottle's only item."""
    data = Bottle([item]).encode(dialect, specialise=False)
    assert data[:8] == struct.pack("<ii", 256, 1)
    return struct.unpack_from("<i", data, 8)[0], data[12:]


@every_case("dialect", Dialect)
@every_case(
    ("item", "code", "value"),
    [
        (True, 9, b"1\0\0\0"),
        (False, 9, bytes(4)),
        (2**31 - 1, 1, b"\xff\xff\xff\x7f"),
        (-(2**31), 1, b"\0\0\0\x80"),
        (2**31, 17, b"\0\0\0\x80\0\0\0\0"),
        (-(2**31) - 1, 17, b"\xff\xff\xff\x7f\xff\xff\xff\xff"),
        (Number(7), 1, b"\7\0\0\0"),
        (Number(-(2**31)), 1, b"\0\0\0\x80"),
        (Number(2**31), 17, b"\0\0\0\x80\0\0\0\0"),
        (Number(-(2**31) - 1), 17, b"\xff\xff\xff\x7f\xff\xff\xff\xff"),
        (Word("a\udcff"), 4, b"\2\0\0\0a\xff"),
        ((1,), 256, b"\1\0\0\0\1\0\0\0\1\0\0\0"),
        (bytearray(b"ab"), 12, b"\2\0\0\0ab"),
        (memoryview(b"ab"), 12, b"\2\0\0\0ab"),
    ],
)
def test_pythons_types_on_the_wire(item, code, value, dialect):
    assert wire_form(item, dialect) == (code, value)


@pytest.mark.parametrize(
    ("item", "reason"),
    [
        (None, "a NoneType cannot go into a Bottle"),
        (2**63, "9223372036854775808 does not fit a Bottle's int"),
        (Int8(128), "128 does not fit a Bottle's Int8"),
        (Float32(1e300), "1e.300 does not fit a Bottle's Float32"),
    ],
)
def test_values_that_have_no_form_are_refused(item, reason):
    with pytest.raises(LocalProtocolError, match=reason):
        Bottle([item]).encode()


def test_only_an_int64_that_would_fit_32_bits_keeps_its_type():
    values = (2**31 - 1, 2**31, -(2**31), -(2**31) - 1)
    again = Bottle.decode(Bottle(map(Int64, values)).encode())
    assert again == [*values] and [type(value) for value in again] == [Int64, int, Int64, int]


def test_a_large_blob_is_not_copied():
    image = bytes(5000)
    before, sent, between, again, after = Bottle(["w", image, 5, image, 6]).encode_parts()
    assert sent.obj is again.obj is image
    assert Bottle.decode(b"".join((before, sent, between, again, after))) == ["w", image, 5, image, 6]
    assert len(Bottle([b"small", 5]).encode_parts()) == 1


def test_the_dialect_of_a_bottle_shows_in_its_type_codes():
    for item, shown in ((0.5, Dialect.YARP4), (Vocab64("longer"), Dialect.YARP4), (5, None)):
        data = Bottle(["a", item, Int8(1)]).encode(Dialect.YARP4)
        assert Bottle.decode(data).dialect is shown
        assert Bottle.decode(data, Dialect.YARP4).dialect is Dialect.YARP4
    assert Bottle([0.5]).dialect is None


def test_what_follows_a_bottle_is_no_part_of_it():
    data = Bottle([1, "a"]).encode()
    for dialect in (None, *Dialect):
        with pytest.raises(RemoteProtocolError, match=f"Bottle of {len(data)} bytes in a message of"):
            Bottle.decode(data + b"x", dialect)
    assert Bottle.decode_from(b"x" + data + b"x", 1) == ([1, "a"], len(data) + 1)


@pytest.mark.parametrize("items", [[5], ["a"], [["a"]], [Properties(["a"])], [5, "a"]], ids=str)
def test_a_message_has_as_many_items_as_allowed(items):
    """However they are nested: those of inner lists count, too."""
    count = sum(2 if isinstance(item, list) else 1 for item in items)
    bottle = Bottle(items * (MAX_ITEMS // count))
    for reader in (BottleScanner().scan, Bottle.decode):
        reader(bottle.encode())
    Bottle.from_text(bottle.to_text())
    bottle.append(5)
    for attempt in (BottleScanner().scan, Bottle.decode):
        with pytest.raises(RemoteProtocolError, match=str(MAX_ITEMS)):
            attempt(bottle.encode())
    with pytest.raises(RemoteProtocolError, match=f"more than {MAX_ITEMS} items"):
        Bottle.from_text(bottle.to_text())


@given(bottles, st.sampled_from(Dialect), st.booleans())
def test_binary_round_trip_keeps_values_and_types(bottle, dialect, specialise):
    data = bottle.encode(dialect, specialise=specialise)
    again = Bottle.decode(data, dialect)
    assert [typed(item) for item in again] == [
        typed(int(item) if isinstance(item, Int64) and not -(2**31) <= item < 2**31 else item)
        for item in bottle
    ] or again.encode(dialect, specialise=specialise) == data


@given(st.lists(items, max_size=3).map(Bottle), st.sampled_from(Dialect))
def test_every_truncation_is_refused_and_the_scanner_finds_the_end(bottle, dialect):
    data = bottle.encode(dialect)
    scanner = BottleScanner(dialect)
    for size in range(len(data)):
        assert scanner.scan(data[:size]) > size
        with pytest.raises(RemoteProtocolError, match="a Bottle"):
            Bottle.decode(data[:size], dialect)
    assert scanner.scan(data) == len(data)


@given(st.binary(max_size=200))
def test_random_bytes_end_in_a_bottle_or_an_error(data):
    for attempt in (lambda: Bottle.decode(data), lambda: BottleScanner().scan(data)):
        try:
            attempt()
        except RemoteProtocolError as error:
            assert str(error)


@given(st.text(max_size=200))
def test_any_text_ends_in_a_bottle_or_an_error(text):
    try:
        bottle = Bottle.from_text(text)
    except RemoteProtocolError:
        nesting = Nesting()
        nesting.feed(text)
        assert nesting.open or text.count(")") or text.count("}") or "\\" in text
        return
    bottle.to_text()


@given(st.lists(st.one_of(st.integers(-(2**63), 2**63 - 1), st.floats(), st.text(), st.binary(max_size=9))))
def test_the_text_of_a_bottle_reads_back_to_the_same_text(values):
    text = Bottle(values).to_text()
    assert Bottle.from_text(text).to_text() == text


@every_case(
    ("text", "value"),
    [
        ("0x10", 16),
        ("+5", 5),
        ("007", 7),
        ("-", 0),
        (".5", 0.5),
        ("1e5", 1e5),
        ("1E5", 1e5),
        ("-e", 0.0),
        ("-.", 0.0),
        ("1.2.3", "1.2.3"),
        ("5000000000", Int64(5000000000)),
        ("1_000", "1_000"),
        (".", "."),
        ("true", Vocab("1")),
        ("false", Vocab(0)),
        ("null", Vocab("null")),
        ("[ok]", Vocab("ok")),
        ('"a\\"b\\n"', 'a"b\n'),
        ('"a\\\nb"', "a\nb"),
        ("{1 2 255}", b"\x01\x02\xff"),
        ("{nan (1) 300}", b"\0\0\x2c"),
        ("(1 (2))", Bottle([1, Bottle([2])])),
        ("-inf", float("-inf")),
        ("2147483647", 2**31 - 1),
        ("2147483648", Int64(2**31)),
        ("-2147483648", -(2**31)),
        ("-2147483649", Int64(-(2**31) - 1)),
        ("99999999999999999999", Int64(2**63 - 1)),
        ("-99999999999999999999", Int64(-(2**63))),
        ("[longer]", Vocab("long")),
    ],
)
def test_tokens_are_what_yarp_takes_them_for(text, value):
    (item,) = Bottle.from_text(text)
    assert typed(item) == typed(value)


@every_case(
    ("value", "text"),
    [
        ("a-b.c_9", "a-b.c_9"),
        ("", '""'),
        ("true", '"true"'),
        ("false", '"false"'),
        ("1a", '"1a"'),
        ("/x", '"/x"'),
        ('a"b\n\\', r'"a\"b\n\\"'),
        (Vocab("ok"), "[ok]"),
        (Vocab(-1), "[ÿÿÿÿ]"),
        (Vocab(0), "false"),
        (True, "true"),
        (False, "false"),
        (100000.0, "100000.0"),
        (0.1, "0.100000000000000005551"),
        (1e30, "1.00000000000000001988e+30"),
        (float("nan"), "nan"),
        (b"\1\xff", "{1 255}"),
        ([1, ["a"]], "(1 (a))"),
    ],
)
def test_values_are_printed_as_yarp_prints_them(value, text):
    assert Bottle([value]).to_text() == text


@pytest.mark.parametrize(
    ("text", "value"),
    [("[four]", Vocab("four")), ("[longer]", Vocab64("longer")), ("[toolongbyfar]", Vocab64("toolongb"))],
)
def test_vocabs_of_yarp_4_have_up_to_eight_letters(text, value):
    (item,) = Bottle.from_text(text, Dialect.YARP4)
    assert typed(item) == typed(value)


def test_commands_are_matched_as_text_whether_strings_or_vocabs():
    assert [word(item) for item in ("get", Vocab("get"), Vocab64("getall"), 5, b"get", ["get"])] == [
        "get", "get", "getall", "", "", "",
    ]  # fmt: skip
    assert repr(Bottle([Vocab("get"), 8])) == "Bottle([Vocab('get'), 8])"


@pytest.mark.parametrize(
    ("items", "value"),
    [
        (["w", 640], 640),
        ([["w", 640]], 640),
        ([1, "h", 480, "w", 640], 640),
        ([["h", 480], ["w", 640, 641]], 640),
        ([[], ["w"], 5, ["w", 640]], 640),
        (["h", "w"], None),
        (["h", 480], None),
        ([], None),
    ],
)
def test_values_are_found_by_key(items, value):
    assert Bottle(items).find("w") == value


@pytest.mark.parametrize(
    "message",
    [
        "0001000000000080",  # -2**31 items
        "00010000ffffff7f",  # 2**31 - 1 items
        "0401000001000000ffffff7f",  # a string of 2 GB
        "0c01000001000000ffffffff",  # a blob of -1 bytes
        "000100000100000005000000",  # an unknown type code
        "5941000000005250",  # an acknowledgement
    ],
)
def test_counts_and_sizes_beyond_the_message_are_refused(message):
    for attempt in (Bottle.decode, BottleScanner().scan):
        with pytest.raises(RemoteProtocolError, match="a Bottle"):
            attempt(bytes.fromhex(message))


def test_the_size_of_a_list_of_numbers_is_known_from_its_count():
    data = Bottle(range(1000)).encode()
    assert BottleScanner().scan(data[:8]) == len(data)


def test_too_deep_nesting_is_refused():
    with pytest.raises(RemoteProtocolError, match="nested"):
        Bottle.decode(bytes.fromhex("0001000001000000") + bytes.fromhex("0001000001000000") * 5000)
    for opening, closing in ("()", "{}", ("({", "})")):
        with pytest.raises(RemoteProtocolError, match="nested"):
            Bottle.from_text(opening * 2000 + closing * 2000)


@pytest.mark.parametrize(("opening", "closing"), ["()", "{}"])
def test_lists_are_nested_as_deep_as_allowed(opening, closing):
    Bottle.from_text(opening * MAX_DEPTH + "x" + closing * MAX_DEPTH)
    with pytest.raises(RemoteProtocolError, match=f"deeper than {MAX_DEPTH}"):
        Bottle.from_text(opening * (MAX_DEPTH + 1) + "x" + closing * (MAX_DEPTH + 1))


@pytest.mark.parametrize("kind", [Bottle, Properties])
def test_binary_lists_are_nested_as_deep_as_allowed(kind):
    bottle = Bottle()
    for _ in range(MAX_DEPTH):
        bottle = Bottle([kind(bottle)])
    data = bottle.encode()
    assert Bottle.decode(data) == bottle and BottleScanner().scan(data) == len(data)
    data = Bottle([kind(bottle)]).encode()
    for attempt in (Bottle.decode, BottleScanner().scan):
        with pytest.raises(RemoteProtocolError, match=f"deeper than {MAX_DEPTH}"):
            attempt(data)


def test_dictionaries_and_long_vocabs():
    bottle = Bottle([Properties([["a", 1]]), Vocab64("longer")])
    again = Bottle.decode(bottle.encode(Dialect.YARP4), Dialect.YARP4)
    assert isinstance(again[0], Properties) and str(again[1]) == "longer"
    with pytest.raises(LocalProtocolError, match="four letters"):
        bottle.encode(Dialect.YARP3)
