"""Frame grabber requests and replies in the dialects of YARP 3.x and YARP 4.0.

Both have the same operations: 3.x in vocabs (``[fgc] [get] [feat] 8``), 4.0 in thrift style
(``getFeature1RPC 8``). The first item of a request identifies its dialect. One table, `Operation`,
serves both sides; this module knows neither cameras nor sockets.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.grabber_values import NAK, VOCAB_FAIL, Value, ValueKind, read_values, write_values
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.values import Dialect, Item, Vocab, word

INT, FLOAT, FLAG, TEXT = ValueKind.INT, ValueKind.FLOAT, ValueKind.FLAG, ValueKind.TEXT

VERSION_METHOD = "getRemoteProtocolVersion"

VERSION_REPLY = bytes.fromhex("0001000001000000 0000 0400 0000 0000")
"""Protocol 0, YARP 4.0.0: a list of one whose content is four bare int16, which is no valid Bottle."""
_DC1394_GETTERS = {
    **dict.fromkeys(("VideoModeMask", "VideoMode", "FPSMask", "FPS", "ISOSpeed", "ColorCoding"), (INT,)),
    **{"BytesPerPacket": (INT,), "OperationMode": (FLAG,), "Transmission": (FLAG,)},
    **{"Format7MaxWindow": (INT,) * 6, "Format7Window": (INT,) * 4, "ColorCodingMask": (INT,)},
}
_DC1394_SETTERS = (
    *("VideoMode", "FPS", "ISOSpeed", "ColorCoding", "Format7Window", "OperationMode", "Transmission"),
    *("Broadcast", "Defaults", "Reset", "Power", "Capture", "BytesPerPacket"),
)
_DC1394: dict[str, tuple[ValueKind, ...]] = {
    **{f"get{name}DC1394RPC": kinds for name, kinds in _DC1394_GETTERS.items()},
    **{f"set{name}DC1394RPC": () for name in _DC1394_SETTERS},
}
"""Methods for FireWire cameras, with the kinds of their results: none of our cameras has them."""
_LEGACY_INTERFACES = frozenset({"fgi", "fgir", "fgc", "visr", "fgfw"})


class ReturnValue(Enum):
    """Result of a call: YARP 4.0's ReturnValue codes."""

    OK = "ok"
    ERROR = "err1"
    NOT_IMPLEMENTED = "err2"
    COMMUNICATION = "err3"
    DEPRECATED = "err4"
    FAILED = "err5"
    NOT_READY = "err6"
    OUT_OF_BOUNDS = "err7"
    UNINITIALISED = "miss"


class Operation(Enum):
    """A request: its thrift method, its 3.x words, the kinds of its arguments and results.

    3.x asks for raw images by an interface of its own, where 4.0 has only one of each.
    """

    WIDTH = ("getWidthRPC", "fgi get w", (), (INT,))
    HEIGHT = ("getHeightRPC", "fgi get h", (), (INT,))
    IMAGE = ("getImageRPC", "fgi get imgr", (), (ValueKind.IMAGE,))
    CROP = ("getImageCropRPC", "fgi get crop", (INT, ValueKind.VERTICES), (ValueKind.IMAGE,))
    RAW_WIDTH = ("", "fgir get w", (), (INT,))
    RAW_HEIGHT = ("", "fgir get h", (), (INT,))
    RAW_IMAGE = ("", "fgir get imgr", (), (ValueKind.IMAGE,))
    RAW_CROP = ("", "fgir get crop", (INT, ValueKind.VERTICES), (ValueKind.IMAGE,))

    DESCRIPTION = ("getCameraDescriptionRPC", "fgc get camd", (), (INT, TEXT))
    HAS_FEATURE = ("hasFeatureRPC", "fgc has feat", (INT,), (FLAG,))
    HAS_ON_OFF = ("hasOnOffRPC", "fgc has onof", (INT,), (FLAG,))
    HAS_AUTO = ("hasAutoRPC", "fgc has auto", (INT,), (FLAG,))
    HAS_MANUAL = ("hasManualRPC", "fgc has man", (INT,), (FLAG,))
    HAS_ONE_PUSH = ("hasOnePushRPC", "fgc has onep", (INT,), (FLAG,))
    GET_VALUE = ("getFeature1RPC", "fgc get feat", (INT,), (FLOAT,))
    GET_VALUES = ("getFeature2RPC", "fgc get fea2", (INT,), (FLOAT, FLOAT))
    GET_ACTIVE = ("getActiveRPC", "fgc get actv", (INT,), (FLAG,))
    GET_MODE = ("getModeRPC", "fgc get mode", (INT,), (INT,))
    SET_VALUE = ("setFeature1RPC", "fgc set feat", (INT, FLOAT), ())
    SET_VALUES = ("setFeature2RPC", "fgc set fea2", (INT, FLOAT, FLOAT), ())
    SET_ACTIVE = ("setActiveRPC", "fgc set actv", (INT, FLAG), ())
    SET_MODE = ("setModeRPC", "fgc set mode", (INT, INT), ())
    SET_ONE_PUSH = ("setOnePushRPC", "fgc set onep", (INT,), ())

    RGB_WIDTH = ("getRgbWidthRPC", "visr get w", (), (INT,))
    RGB_HEIGHT = ("getRgbHeightRPC", "visr get h", (), (INT,))
    GET_RESOLUTION = ("getRgbResolutionRPC", "visr get res", (), (INT, INT))
    SET_RESOLUTION = ("setRgbResolutionRPC", "visr set res", (INT, INT), ())
    CONFIGURATIONS = ("getRgbSupportedConfigurationsRPC", "visr get conf", (), (ValueKind.CONFIGURATIONS,))
    GET_FIELD_OF_VIEW = ("getRgbFOVRPC", "visr get fov", (), (FLOAT, FLOAT))
    SET_FIELD_OF_VIEW = ("setRgbFOVRPC", "visr set fov", (FLOAT, FLOAT), ())
    INTRINSICS = ("getRgbIntrinsicParamRPC", "visr get intp", (), (ValueKind.PROPERTIES,))
    GET_MIRROR = ("getRgbMirroringRPC", "visr get mirr", (), (FLAG,))
    SET_MIRROR = ("setRgbMirroringRPC", "visr set mirr", (FLAG,), ())

    def __init__(
        self, method: str, words: str, arguments: tuple[ValueKind, ...], results: tuple[ValueKind, ...]
    ) -> None:
        self.method = method
        self.words = tuple(words.split())
        self.arguments = arguments
        self.results = results

    @property
    def interface(self) -> str:
        """The 3.x interface word: `fgi`, `fgir`, `fgc` or `visr`."""
        return self.words[0]

    @property
    def verb(self) -> str:
        """`get`, `set` or `has`; it decides the form of a 3.x reply."""
        return self.words[1]


_BY_METHOD = {operation.method: operation for operation in Operation if operation.method}
_BY_WORDS = {operation.words: operation for operation in Operation}


@dataclass(frozen=True)
class Call:
    """A request of either dialect."""

    operation: Operation
    arguments: tuple[Value, ...] = ()
    dialect: Dialect = Dialect.YARP3
    "Dialect of the request and of its reply."


@dataclass(frozen=True)
class CallReply:
    """The outcome of a call."""

    values: tuple[Value, ...] = ()
    status: ReturnValue = ReturnValue.OK
    text: str = ""
    "Reason of a failure; only 3.x image replies carry it."

    @property
    def ok(self) -> bool:
        """Whether `values` are valid."""
        return self.status is ReturnValue.OK


@dataclass(frozen=True)
class RefusedRequest:
    """A request that is no call of ours, and the message to answer it with."""

    message: bytes
    reason: str = ""
    "For the log; empty where nothing is wrong with the request."


def decode_request(message: Buffer) -> Call | RefusedRequest:
    """Read a request in either dialect. Raises RemoteProtocolError where it is no Bottle."""
    return read_request(Bottle.decode(message))


def read_request(request: Bottle) -> Call | RefusedRequest:
    """Parse a request; words may be strings or vocabs, since users type both."""
    first = word(request[0]) if request else ""
    if first in _LEGACY_INTERFACES:
        return _read_legacy(request)
    if isinstance(request[0] if request else None, str):
        return _read_thrift(first, request)
    return _unknown(NAK, request)


def encode_request(call: Call) -> bytes:
    """Return the request's message. Raises LocalProtocolError for a raw image asked of 4.0."""
    operation = call.operation
    arguments = write_values(operation.arguments, call.arguments, call.dialect)
    if call.dialect is Dialect.YARP4:
        if not operation.method:
            raise LocalProtocolError(f"YARP 4.0 has no raw image interface to ask for {operation.name}")
        return Bottle([operation.method, *arguments], specialised=False).encode(
            Dialect.YARP4, specialise=False
        )
    return Bottle([*map(Vocab, operation.words), *arguments]).encode(Dialect.YARP3)


def encode_reply(call: Call, reply: CallReply) -> list[Buffer]:
    """Return the reply's message, in pieces so that an image need not be copied."""
    if call.dialect is Dialect.YARP4:
        return _thrift_reply(call.operation.results, reply)
    operation = call.operation
    values = _results(operation.results, reply, call.dialect)
    if operation.verb == "set":
        return _parts([Vocab(operation.interface), Vocab("set"), int(reply.ok)])
    if not reply.ok and operation.interface != "fgc":
        text = (
            [reply.text or "Could not retrieve image from device."] if operation.interface != "visr" else []
        )
        return _parts([VOCAB_FAIL, *text])
    if operation.verb == "has":
        # YARP always answers with [feat], and repeats the request's word as a plain integer.
        return _parts([Vocab("fgc"), Vocab("has"), Vocab("feat"), int(Vocab(operation.words[2])), *values])
    return _parts([Vocab(operation.interface), Vocab(operation.words[2]), Vocab("is"), *values])


def read_reply(call: Call, reply: Sequence[Item]) -> CallReply:
    """Read the reply to `call`.

    A 3.x getter of `fgc` cannot report a failure; its values are then arbitrary. Raises
    RemoteProtocolError for anything but a reply to this call.
    """
    if call.dialect is Dialect.YARP4:
        return _read_thrift_reply(call.operation, reply)
    return _read_legacy_reply(call.operation, reply)


def _read_legacy(request: Bottle) -> Call | RefusedRequest:
    words = tuple(word(item) for item in request[:3])
    interface = words[0]
    operation = _BY_WORDS.get(words)
    if operation is None:
        return RefusedRequest(_unknown_legacy(interface, words), f"{_asked(request)} is not known")
    try:
        values = read_values(operation.arguments, request[3:], Dialect.YARP3)
    except RemoteProtocolError as error:
        reply = encode_reply(Call(operation), CallReply(status=ReturnValue.FAILED, text=str(error)))
        return RefusedRequest(b"".join(reply), f"{_asked(request)}: {error}")
    return Call(operation, values)


def _unknown_legacy(interface: str, words: tuple[str, ...]) -> bytes:
    """Return a 3.x server's reply to an unknown command."""
    if interface == "visr":
        return _single(VOCAB_FAIL)
    if interface == "fgfw":
        return _single("command not recognized")
    if interface in ("fgi", "fgir") and words[1:2] != ("get",):
        return Bottle([VOCAB_FAIL, "Received an unknown command"]).encode()
    return _single(NAK)


def _read_thrift(method: str, request: Bottle) -> Call | RefusedRequest:
    if method == VERSION_METHOD and len(request) == 1:
        return RefusedRequest(VERSION_REPLY)
    if method == "help":
        return RefusedRequest(_help())
    if method in _DC1394:
        reply = CallReply(status=ReturnValue.NOT_IMPLEMENTED)
        return RefusedRequest(
            b"".join(_thrift_reply(_DC1394[method], reply)), f"{method} is for FireWire cameras"
        )
    operation = _BY_METHOD.get(method)
    if operation is None:
        # A typed word is a string too; 3.x answers it with [nak].
        thrift = method.endswith("RPC") or _written_by_thrift(request)
        return _unknown(VOCAB_FAIL if thrift else NAK, request)
    try:
        return Call(operation, read_values(operation.arguments, request[1:], Dialect.YARP4), Dialect.YARP4)
    except RemoteProtocolError as error:
        return RefusedRequest(_single(VOCAB_FAIL), f"{_asked(request)}: {error}")


def _written_by_thrift(request: Bottle) -> bool:
    """Return whether items of one type each carry its code; programs of 3.x leave it out."""
    return request.specialised is False and len({type(item) for item in request}) == 1


def _thrift_reply(kinds: tuple[ValueKind, ...], reply: CallReply) -> list[Buffer]:
    status = Vocab(reply.status.value)
    # A method whose only result is the status answers with it bare, others with a list first.
    head: list[Item] = [Bottle([status], specialised=False)] if kinds else [status]
    values = _results(kinds, reply, Dialect.YARP4)
    return Bottle([*head, *values], specialised=False).encode_parts(Dialect.YARP4, specialise=False)


def _results(kinds: tuple[ValueKind, ...], reply: CallReply, dialect: Dialect) -> list[Item]:
    """Return the reply's values, or as many zeros if it failed."""
    return write_values(kinds, reply.values if reply.ok else tuple(kind.zero for kind in kinds), dialect)


def _read_thrift_reply(operation: Operation, reply: Sequence[Item]) -> CallReply:
    head = reply[0] if reply else None
    if isinstance(head, list):
        head = head[0] if head else None
    try:
        status = ReturnValue(word(head))
    except ValueError:
        raise RemoteProtocolError(f"{operation.method} was answered with {_shown(reply)}") from None
    if status is not ReturnValue.OK:
        return CallReply(status=status)
    return CallReply(read_values(operation.results, reply[1:], Dialect.YARP4))


def _read_legacy_reply(operation: Operation, reply: Sequence[Item]) -> CallReply:
    asked = " ".join(operation.words)
    first = word(reply[0]) if reply else ""
    if first in ("fail", "nak"):
        status = ReturnValue.NOT_IMPLEMENTED if first == "nak" else ReturnValue.FAILED
        return CallReply(status=status, text=" ".join(item for item in reply[1:] if isinstance(item, str)))
    if first != operation.interface:
        raise RemoteProtocolError(f"'{asked}' was answered with {_shown(reply)}")
    if operation.verb == "set":
        accepted = len(reply) > 2 and isinstance(reply[2], int) and bool(reply[2])
        return CallReply(status=ReturnValue.OK if accepted else ReturnValue.FAILED)
    start = 4 if operation.verb == "has" else 3
    return CallReply(read_values(operation.results, reply[start:], Dialect.YARP3))


def _help() -> bytes:
    lines: Iterable[str] = ["*** Available commands:", *_BY_METHOD, VERSION_METHOD, "help"]
    return Bottle([Vocab("many"), Bottle(lines, specialised=False)], specialised=False).encode(Dialect.YARP4)


def _unknown(answer: Vocab, request: Bottle) -> RefusedRequest:
    return RefusedRequest(_single(answer), f"{_asked(request)} is not known; `help` lists the requests")


def _single(item: Item) -> bytes:
    return Bottle([item]).encode()


def _parts(items: list[Item]) -> list[Buffer]:
    return Bottle(items).encode_parts(Dialect.YARP3)


def _asked(request: Sequence[Item]) -> str:
    """Return the start of a request for the log, without rendering what may be megabytes."""
    words = (str(item)[:40] if isinstance(item, (str, int, float)) else "…" for item in request[:4])
    return f"'{' '.join(words)}'"


def _shown(items: Sequence[Item]) -> str:
    text = Bottle(items[:4]).to_text()
    return f"'{text[:80]}'"


__all__ = [
    *("Call", "Kind", "Operation", "Refusal", "Reply", "Status", "VERSION_METHOD", "VERSION_REPLY"),
    *("decode_request", "encode_reply", "encode_request", "read_reply", "read_request"),
]
