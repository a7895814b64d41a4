"""The arguments and results of frame grabber calls, and how each dialect writes them.

The vocabulary of `net.tree` on the same port is an addition to YARP's. A request is a Bottle of strings,
``genicam VERB ARGUMENT…``; the reply is ``genicam ok JSON`` or ``genicam error KIND MESSAGE FEATURE``. Other
servers answer the unknown word with ``[nak]`` (3.x) or ``[fail]`` (4.0), so a client may always ask. Users
can type it too: ``genicam write Gain 5`` into ``yarp rpc``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from typing import Any, Final, NamedTuple

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import GrabberError, RemoteProtocolError
from grabbergui.core.identity import DeviceInfo
from grabbergui.net.tree import dumps, error_of, loads, read_info, table_of
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Dialect, Item, Vocab, word

OK: Final = Vocab("ok")
VOCAB_FAIL: Final = Vocab("fail")
NAK: Final = Vocab("nak")

MAX_VERTICES: Final = 1024

EMPTY_IMAGE: Final = Bottle(
    [Vocab("mat"), Vocab(0), Bottle([0] * 5, specialised=True), b""], specialised=False
)
"""Takes the place of the image in a failed reply: no pixel code, no size."""
Vertices = tuple[tuple[int, int], ...]
_COEFFICIENTS: Final = ("k1", "k2", "t1", "t2", "k3", "k4", "k5", "k6")
"""YARP's names in OpenCV's order. YARP itself knows `plumb_bob` only, the first five."""
TREE_WORD = "genicam"


class Configuration(NamedTuple):
    """An image size and rate that a camera offers."""

    width: int
    height: int
    rate: float
    "Frames per second."
    pixel_code: str
    "YARP's, e.g. `rgb`."


Value = int | float | str | Bottle | Vertices | tuple[Configuration, ...] | Mapping[str, Item]


class ValueKind(Enum):
    """The type of a value."""

    INT = "integer"
    FLOAT = "number"
    FLAG = "flag"
    TEXT = "string"
    IMAGE = "image"
    VERTICES = "list of vertices"
    CONFIGURATIONS = "list of configurations"
    PROPERTIES = "property list"

    @property
    def zero(self) -> Value:
        """Return the value that a failed reply contains instead."""
        return _ZEROS[self]


_ZEROS: Final[dict[ValueKind, Value]] = {
    ValueKind.INT: 0,
    ValueKind.FLOAT: 0.0,
    ValueKind.FLAG: False,
    ValueKind.TEXT: "",
    ValueKind.IMAGE: EMPTY_IMAGE,
    ValueKind.VERTICES: (),
    ValueKind.CONFIGURATIONS: (),
    ValueKind.PROPERTIES: {},
}


def write_values(kinds: Sequence[ValueKind], values: Sequence[Value], dialect: Dialect) -> list[Item]:
    """Encode values as items."""
    items: list[Item] = []
    for kind, value in zip(kinds, values, strict=True):
        items += _write(kind, value, dialect)
    return items


def read_values(kinds: Sequence[ValueKind], items: Sequence[Item], dialect: Dialect) -> tuple[Value, ...]:
    """Decode items to values.

    Numbers may be of any type, as in YARP. Raises RemoteProtocolError for too few items or one of the wrong
    kind, and from 4.0 also for too many.
    """
    left = iter(items)
    values = tuple(_read(kind, left, dialect) for kind in kinds)
    if dialect is Dialect.YARP4 and next(left, None) is not None:
        raise RemoteProtocolError(f"{len(items)} items where {len(kinds)} are expected")
    return values


def _write(kind: ValueKind, value: Any, dialect: Dialect) -> list[Item]:
    thrift = dialect is Dialect.YARP4
    if kind is ValueKind.INT:
        return [int(value)]
    if kind is ValueKind.FLOAT:
        return [float(value)]
    if kind is ValueKind.FLAG:
        return [(OK if value else VOCAB_FAIL) if thrift else int(value)]
    if kind is ValueKind.VERTICES:
        if thrift:
            return [_generic(_generic(vertex) for vertex in value)]
        return [Bottle(coordinate for vertex in value for coordinate in vertex)]
    if kind is ValueKind.CONFIGURATIONS:
        rows = [[c.width, c.height, float(c.rate), Vocab(c.pixel_code)] for c in value]
        if thrift:
            return [_generic(_generic([*row[:3], int(row[3])]) for row in rows)]
        return [len(rows), *(item for row in rows for item in row)]
    if kind is ValueKind.PROPERTIES:
        return [_usual([key, entry] for key, entry in value.items())]
    if kind is ValueKind.IMAGE:
        mat, code, layout, pixels = value
        return [Bottle([mat, code, _usual(layout), pixels], specialised=False)]
    return [value]


def _read(kind: ValueKind, left: Iterator[Item], dialect: Dialect) -> Value:
    item = next(left, None)
    if kind is ValueKind.INT or kind is ValueKind.FLOAT:
        return _number(item, kind)
    if kind is ValueKind.FLAG:
        return _flag(item)
    if kind is ValueKind.TEXT and isinstance(item, str):
        return item
    if kind is ValueKind.CONFIGURATIONS:
        return _configurations(item, left, dialect)
    if isinstance(item, list):
        if kind is ValueKind.IMAGE and len(item) == 4 and isinstance(item[2], list):
            return Bottle(item)
        if kind is ValueKind.VERTICES:
            return _vertices(item)
        if kind is ValueKind.PROPERTIES:
            return {str(entry[0]): entry[1] for entry in item if isinstance(entry, list) and len(entry) == 2}
    raise RemoteProtocolError(f"{_described(item)} where a {kind.value} is expected")


def _number(item: Item | None, kind: ValueKind) -> int | float:
    if isinstance(item, (int, float)) and not word(item):
        if kind is ValueKind.FLOAT:
            return float(item)
        if math.isfinite(item):
            return int(item)
    raise RemoteProtocolError(f"{_described(item)} where a number is expected")


def _flag(item: Item | None) -> bool:
    """Decode 0, 1 or a word for it. A failing 3.x server sends an arbitrary number from its memory."""
    known = {0: False, 1: True, "fail": False, "ok": True, "false": False, "true": True, "1": True}
    key = word(item) or item
    if isinstance(key, (int, str)) and key in known:
        return known[key]
    raise RemoteProtocolError(f"{item!r} where 0 or 1 is expected")


def _vertices(items: Sequence[Item]) -> Vertices:
    """Decode vertices from pairs (4.0) or from one flat list (3.x)."""
    flat: list[Item] = []
    for item in items[: 2 * MAX_VERTICES + 1]:
        flat += item if isinstance(item, list) else [item]
    if len(flat) > 2 * MAX_VERTICES:
        raise RemoteProtocolError(f"more than {MAX_VERTICES} vertices")
    numbers = [int(_number(item, ValueKind.INT)) for item in flat]
    return tuple(zip(numbers[::2], numbers[1::2], strict=False))


def _configurations(item: Item | None, left: Iterator[Item], dialect: Dialect) -> tuple[Configuration, ...]:
    if dialect is Dialect.YARP4:
        if not isinstance(item, list):
            raise RemoteProtocolError(f"{_described(item)} where a list of configurations is expected")
        return tuple(_configuration(row) for row in item if isinstance(row, list))
    rest = list(left)
    count = int(_number(item, ValueKind.INT))
    if not 0 <= 4 * count <= len(rest):
        raise RemoteProtocolError(f"{count} configurations claimed, {len(rest) // 4} sent")
    return tuple(_configuration(rest[index : index + 4]) for index in range(0, 4 * count, 4))


def _configuration(row: Sequence[Item]) -> Configuration:
    if len(row) != 4 or not isinstance(row[3], int):
        raise RemoteProtocolError("a configuration is not width, height, rate, pixel code")
    width, height, rate = (
        _number(item, kind)
        for item, kind in zip(row, (ValueKind.INT, ValueKind.INT, ValueKind.FLOAT), strict=False)
    )
    return Configuration(int(width), int(height), rate, str(Vocab(int(row[3]) & 0x7FFFFFFF)))


def _generic(items: Iterable[Item]) -> Bottle:
    """Return a nested list as thrift's readers need it: every item with its own code."""
    return Bottle(items, specialised=False)


def _usual(items: Iterable[Item]) -> Bottle:
    """Encode a nested list as YARP does, 4.0 included: items of one type without their codes."""
    return Bottle((_usual(item) if isinstance(item, list) else item for item in items), specialised=True)


def _described(item: Item | None) -> str:
    return "nothing" if item is None else f"a {type(item).__name__}"


def intrinsics(calibration: Calibration, seconds: float) -> Mapping[str, Item]:
    """Return the properties of `getRgbIntrinsicParam`; lengths in pixels, `seconds` since 1970 as the stamp.

    The physical focal length is 0, as YARP writes one that is not known: a calibration does not contain it.
    """
    (focal_x, _, x), (_, focal_y, y), _ = calibration.matrix.tolist()
    names = ("k1", "k2", "k3", "k4") if calibration.fisheye else _COEFFICIENTS
    lens = zip(names, calibration.distortion.tolist(), strict=False)
    return {
        "physFocalLength": 0.0,
        "focalLengthX": focal_x,
        "focalLengthY": focal_y,
        "principalPointX": x,
        "principalPointY": y,
        "stamp": seconds,
        "distortionModel": calibration.distortion_model,
        **dict(lens),
    }


def tree_request(verb: str, *arguments: str) -> Bottle:
    """Return the message that asks for `verb`."""
    return Bottle([TREE_WORD, verb, *arguments])


def is_tree_request(message: Sequence[Item]) -> bool:
    """Return whether a message is in this vocabulary."""
    return bool(message) and word(message[0]) == TREE_WORD


def tree_success(result: object) -> Bottle:
    """Return the reply that carries a result, anything that `net.tree.dumps` takes."""
    return Bottle([TREE_WORD, "ok", dumps(result)])


def tree_failure(error: GrabberError) -> Bottle:
    """Return the reply that carries an error; the other end raises it again."""
    return Bottle([TREE_WORD, "error", type(error).__name__, str(error), getattr(error, "feature", "")])


def read_tree_reply(reply: Sequence[Item]) -> Any:
    """Return the plain data of a reply.

    Raises the error that the other end reported, RemoteProtocolError for anything but a reply of this
    vocabulary.
    """
    texts = [item for item in reply if isinstance(item, str)]
    if len(texts) != len(reply) or texts[:1] != [TREE_WORD] or len(texts) < 3:
        raise RemoteProtocolError(f"'{TREE_WORD}' was answered with something else")
    if texts[1] == "ok":
        return loads(texts[2])
    raise error_of(texts[2], texts[3] if len(texts) > 3 else "", texts[4] if len(texts) > 4 else "")


def tree_understood(reply: Sequence[Item]) -> bool:
    """Return whether the other end knows this vocabulary."""
    return len(reply) > 1 and reply[0] == TREE_WORD


def read_tree_hello(reply: Sequence[Item]) -> DeviceInfo:
    """Return the camera behind a server that answered `hello`. Raises as `read_tree_reply`."""
    return read_info(table_of(read_tree_reply(reply)).get("info"))
