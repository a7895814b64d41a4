"""Bottles as bytes: one table that is written, read, cut at every length, and measured in a stream.

Each case is chosen, not drawn, so that the same change of the codec fails the same tests on every run.
"""

import pytest

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Bottle, Properties
from grabbergui.net.yarp.os.framing import BottleScanner
from grabbergui.net.yarp.os.values import Dialect, Float32, Int8, Int16, Int64, Item, Vocab, Vocab64

Y3, Y4 = Dialect.YARP3, Dialect.YARP4
PLAIN = {"specialised": False}

SAME_IN_BOTH = {
    "nothing": (Bottle(), "00010000 00000000"),
    "an int": (Bottle([5]), "01010000 01000000 05000000"),
    "ints": (Bottle([5, -1, 7]), "01010000 03000000 05000000 ffffffff 07000000"),
    "ints with their codes": (
        Bottle([5, -1], **PLAIN),
        "00010000 02000000 01000000 05000000 01000000 ffffffff",
    ),
    "bytes": (Bottle([Int8(1), Int8(-1), Int8(3)]), "20010000 03000000 01 ff 03"),
    "shorts": (Bottle([Int16(1), Int16(-2)]), "40010000 02000000 0100 feff"),
    "longs": (Bottle([2**31, Int64(1)]), "11010000 02000000 0000008000000000 0100000000000000"),
    "vocabs": (Bottle([Vocab("get"), Vocab("ok")]), "09010000 02000000 67657400 6f6b0000"),
    "strings": (
        Bottle(["ab", "", "\u00e9\udcff"]),
        "04010000 03000000 02000000 6162 00000000 03000000 c3a9ff",
    ),
    "strings with their codes": (
        Bottle(["ab", "c\udcff"], **PLAIN),
        "00010000 02000000 04000000 02000000 6162 04000000 02000000 63ff",
    ),
    "blobs": (Bottle([b"\x01\x02", b""]), "0c010000 02000000 02000000 0102 00000000"),
    "items of several types": (
        Bottle([5, "ab", b"\x07", Int8(1), Vocab("ok"), "c"]),
        "00010000 06000000 01000000 05000000 04000000 02000000 6162 0c000000 01000000 07 20000000 01"
        "09000000 6f6b0000 04000000 01000000 63",
    ),
    "lists": (
        Bottle([Bottle([1, 2]), Bottle(), Bottle(["a", 3])]),
        "00010000 03000000 01010000 02000000 01000000 02000000 00010000 00000000"
        "00010000 02000000 04000000 01000000 61 01000000 03000000",
    ),
    "items around lists": (
        Bottle(["a", Bottle([Bottle([b"b", b"c"]), 4]), 5]),
        "00010000 03000000 04000000 01000000 61 00010000 02000000"
        "0c010000 02000000 01000000 62 01000000 63 01000000 04000000 01000000 05000000",
    ),
    "dictionaries": (
        Bottle([Properties([Bottle(["a", 1])]), Properties(), 5]),
        "00010000 03000000 00030000 00010000 01000000 00010000 02000000 04000000 01000000 61"
        "01000000 01000000 00030000 00010000 00000000 01000000 05000000",
    ),
}
DIFFERENT = {
    "floats, 3.x": (Y3, Bottle([0.5, 2.0]), "0a010000 02000000 000000000000e03f 0000000000000040"),
    "floats, 4.0": (Y4, Bottle([0.5, 2.0]), "14010000 02000000 000000000000e03f 0000000000000040"),
    "short floats, 3.x": (
        Y3,
        Bottle([Float32(0.5), 1]),
        "00010000 02000000 80000000 0000003f 01000000 01000000",
    ),
    "short floats, 4.0": (
        Y4,
        Bottle([Float32(0.5), 1]),
        "00010000 02000000 0a000000 0000003f 01000000 01000000",
    ),
    "long vocabs, 4.0": (
        Y4,
        Bottle([Vocab64("longer"), 1]),
        "00010000 02000000 12000000 6c6f6e6765720000 01000000 01000000",
    ),
}
CASES = [
    *(
        pytest.param(dialect, bottle, bytes.fromhex(data), id=f"{name}, {dialect.value}")
        for name, (bottle, data) in SAME_IN_BOTH.items()
        for dialect in Dialect
    ),
    *(
        pytest.param(dialect, bottle, bytes.fromhex(data), id=name)
        for name, (dialect, bottle, data) in DIFFERENT.items()
    ),
]
table = pytest.mark.parametrize(("dialect", "bottle", "data"), CASES)


def typed(item: Item) -> object:
    """Return a value with its class, and those of a list's items."""
    return (type(item), [typed(part) for part in item]) if isinstance(item, list) else (type(item), item)


@table
def test_a_bottle_is_these_bytes(dialect: Dialect, bottle: Bottle, data: bytes) -> None:
    assert bottle.encode(dialect).hex() == data.hex()


@table
def test_these_bytes_are_the_bottle(dialect: Dialect, bottle: Bottle, data: bytes) -> None:
    again = Bottle.decode(data, dialect)
    assert typed(again) == typed(bottle)
    assert again.encode(dialect, specialise=not again.specialised) == data, "the message's form is kept"
    assert Bottle.decode_from(b"x" + data + b"y", 1, dialect) == (bottle, 1 + len(data))


@table
def test_a_bottle_cut_short_is_refused(dialect: Dialect, bottle: Bottle, data: bytes) -> None:
    for size in range(len(data)):
        with pytest.raises(RemoteProtocolError, match=r"^a Bottle (ends at byte|claims)"):
            Bottle.decode(data[:size], dialect)


@table
def test_the_end_is_found_wherever_a_stream_is_cut(dialect: Dialect, bottle: Bottle, data: bytes) -> None:
    growing = BottleScanner(dialect)
    for size in range(len(data)):
        once = BottleScanner(dialect)
        needed = once.scan(data[:size])
        assert size < needed <= len(data), "never more than the Bottle has"
        assert growing.scan(data[:size]) == needed
        assert once.scan(data) == len(data)
    assert growing.scan(data) == len(data)
    assert BottleScanner(dialect).scan(data + data) == len(data), "the next Bottle is left alone"


@pytest.mark.parametrize("own", [True, False, None])
@pytest.mark.parametrize("specialise", [True, False])
def test_a_bottle_that_knows_its_form_is_written_so(own: bool | None, specialise: bool) -> None:
    short = specialise if own is None else own
    start = "01010000 01000000" if short else "00010000 01000000 01000000"
    assert Bottle([5], specialised=own).encode(specialise=specialise) == bytes.fromhex(start + "05000000")


@pytest.mark.parametrize("value", [True, False])
def test_booleans_are_written_as_vocabs(value: bool) -> None:
    assert Bottle([value, value]).encode()[8:] == (b"1\0\0\0" if value else bytes(4)) * 2


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ("00010000 ffffffff", "a Bottle claims -1 items, 0 bytes are left"),
        ("20010000 04000000 010203", "a Bottle claims 4 items, 3 bytes are left"),
        ("01010000 02000000 010203", "a Bottle ends at byte 11 within 2 items of type code 1"),
        ("04010000 01000000 02000000 61", "a Bottle ends at byte 13 within a string of 2 bytes"),
        ("04010000 01000000 feffffff 61", "a Bottle has a string of -2 bytes"),
        ("00010000 01000000 0c000000 ffffffff", "a Bottle has a blob of -1 bytes"),
        ("05010000 01000000 00", "a Bottle has an item of unknown type code 5"),
    ],
)
def test_the_reason_names_what_is_wrong_with_the_bytes(data: str, reason: str) -> None:
    with pytest.raises(RemoteProtocolError) as caught:
        Bottle.decode(bytes.fromhex(data), Y3)
    assert str(caught.value) == reason


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ("00010000 ffffffff", r"a Bottle claims -1 items"),
        ("04010000 01000000 feffffff", "a Bottle has an item of -2 bytes"),
        ("00010000 01000000 0c000000 ffffffff", "a Bottle has an item of -1 bytes"),
        ("05010000 01000000", "a Bottle has an item of unknown type code 5"),
    ],
)
def test_the_scanner_refuses_before_more_arrives(data: str, reason: str) -> None:
    with pytest.raises(RemoteProtocolError, match=f"^{reason}"):
        BottleScanner().scan(bytes.fromhex(data))
