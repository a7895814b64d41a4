"""URIs of sources: `sim:`, `gige:192.168.0.10`, `yarp:/grabber?carrier=mjpeg`.

The options of each kind of source are the fields of a dataclass: `read_options` turns a URI into an instance,
and `option_rows` lists them for `--help` and for the reference in the docs. No function here opens a socket
or imports a driver.
"""

from __future__ import annotations

import difflib
import ipaddress
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields
from pathlib import PurePath
from typing import Any, NamedTuple, TypeVar
from urllib.parse import parse_qsl, quote, unquote, urlencode

from grabbergui.core.errors import UsageError
from grabbergui.core.features import parse_switch

SIMULATED = "sim:"
"""The built-in simulated camera."""

_SCHEME = re.compile(r"[a-z][a-z0-9+.-]*", re.ASCII)
_MAC = re.compile(r"[0-9a-f]{2}([:-][0-9a-f]{2}){5}", re.ASCII | re.IGNORECASE)
_PLAIN = "/:@,;+=~!$&'()*[]#"
"Characters that are not escaped in a name. A question mark, space or percent sign would be misread."
_LIKE_AN_ADDRESS = re.compile(r"([0-9]+(?:\.[0-9]+){2,3})(?::[0-9]*)?", re.ASCII)
Options = TypeVar("Options")


@dataclass(frozen=True)
class SourceUri:
    """A URI: the kind of source, its name, and options."""

    scheme: str
    "`sim`, `gige`, `u3v`, `gentl`, `aravis`, `v4l2`, `twin`, `yarp`, `ros2`, `file`, `rig`."
    name: str = ""
    "An address, serial number, port or topic; empty means the first found."
    options: dict[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: str) -> SourceUri:
        """Parse a URI as a user types it. Raises UsageError."""
        scheme, colon, rest = text.strip().partition(":")
        scheme = scheme.lower()
        if not colon or not _SCHEME.fullmatch(scheme):
            raise UsageError(f"'{text}' is no source; {_with_kind(text.strip())}")
        # People type two slashes out of habit; one begins a YARP port or a ROS topic.
        name, _, query = rest.removeprefix("//").partition("?")
        if query and "=" not in query:
            raise UsageError(f"'{text}': write options as ?name=value&name=value")
        return cls(
            scheme,
            unquote(name, errors="surrogateescape"),  # file names need not be UTF-8
            dict(parse_qsl(query, keep_blank_values=True)),
        )

    def __str__(self) -> str:
        query = "?" + urlencode(self.options) if self.options else ""
        slashes = "//" if self.name.startswith("//") else ""  # parsing removes two
        return f"{self.scheme}:{slashes}{quote(self.name, safe=_PLAIN, errors='surrogateescape')}{query}"


def proposals(text: str) -> list[str]:
    """Return the URIs that a name without its kind may mean, by its form; none for a serial number."""
    if is_ip_address(text) or _MAC.fullmatch(text):
        kinds = ["gige"]
    elif text.startswith("/dev/video"):
        kinds = ["v4l2"]
    elif text.lower().endswith(".zip"):
        kinds = ["twin"]
    elif text.startswith(("~", "./", "../")) or PurePath(text).suffix[1:2].isalpha():
        kinds = ["file"]
    elif text.startswith("/"):
        kinds = ["yarp", "ros2", "file"]
    else:
        kinds = []
    return [f"{kind}:{text}" for kind in kinds]


def _with_kind(text: str) -> str:
    """Propose URIs for a name without its kind."""
    uris = proposals(text)
    if not uris:
        return "write its kind first, as in sim: or gige:192.168.0.10"
    *others, last = uris
    return f"did you mean {', '.join(others)} or {last}?" if others else f"did you mean {last}?"


def is_ip_address(name: str) -> bool:
    """Return whether a source's name is an IPv4 address, not a serial number or another name."""
    try:
        ipaddress.IPv4Address(name)
    except ValueError:
        return False
    return True


def check_address(uri: SourceUri, port: int) -> None:
    """Raise UsageError for the name of a camera on a network that is meant as an address and is none.

    `port` is the one at which all of them listen.
    """
    match = _LIKE_AN_ADDRESS.fullmatch(uri.name)
    if match is None or is_ip_address(uri.name):
        return
    if is_ip_address(match[1]):
        raise UsageError(f"{uri}: cameras listen at port {port} only; write {uri.scheme}:{match[1]}")
    raise UsageError(
        f"{uri}: {uri.name} is no IPv4 address, which has four numbers from 0 to 255 without leading zeros,"
        f" as in {uri.scheme}:192.168.0.10"
    )


@dataclass(frozen=True)
class NoOptions:
    """The options of a kind of source that has none."""


class OptionRow(NamedTuple):
    """The documentation of an option."""

    name: str
    form: str
    "The allowed values, as in `0|1` or `BYTES`."
    default: str
    "The default value; empty if that is the camera's own or none."
    meaning: str


def _switch(text: str) -> bool:
    return parse_switch(text or "1")  # an option without a value is on


def _number(low: float, high: float, kind: Callable[[str], Any] = float) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        number = kind(text)
        if not low <= number <= high:
            raise ValueError(text)
        return number

    return read


def _one_of(*choices: str) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in choices:
            raise ValueError(text)
        return text

    return read


def _option(default: Any, form: str, meaning: str, read: Callable[[str], Any] = str) -> Any:
    """Return a dataclass field. `read` converts an option's text, and raises ValueError for a bad one."""
    return field(default=default, metadata={"form": form, "meaning": meaning, "read": read})


@dataclass(frozen=True)
class SimulatedOptions:
    """`sim:` values at power-on, which the simulated camera's registers validate."""

    width: str = _option("", "PIXELS", "width of the image")
    height: str = _option("", "PIXELS", "height of the image")
    fps: str = _option("", "HZ", "frame rate; the exposure time is shortened to allow it")
    pixel_format: str = _option("", "FORMAT", "a PFNC name that the camera has, as in `BayerRG8`")
    exposure: str = _option("", "US", "exposure time in microseconds")
    gain: str = _option("", "DB", "gain in decibels")
    test_pattern: str = _option("", "NAME", "a test pattern instead of the scene, as in `GreyHorizontalRamp`")
    setting_latency: str = _option("", "FRAMES", "frames until a changed setting shows in the image")
    serial: str = _option("", "TEXT", "serial number")
    user_id: str = _option("", "TEXT", "user-defined name")


@dataclass(frozen=True)
class DescriptionOption:
    """The option of every kind of source that reads a GenICam description from the camera."""

    description: str = _option(
        "",
        "FILE",
        "the camera's description (`.xml` or `.zip`), for a camera whose own cannot be read; it is kept for "
        "cameras of that model",
    )


@dataclass(frozen=True)
class GigeUriOptions(DescriptionOption):
    """`gige:` the stream's transmission and reception."""

    packet_size: str = _option(
        "auto",
        "auto|keep|BYTES",
        "size of the stream's IP packets. `auto` requests test packets and uses the largest size that "
        "arrives (on the loopback the camera's own), `keep` leaves the camera's size as it is",
    )
    incomplete: bool = _option(
        False, "0|1", "deliver frames with missing packets too; otherwise they are only counted", _switch
    )
    resend: bool = _option(True, "0|1", "request lost packets again", _switch)
    packet_delay: str = _option(
        "", "TIME", "pause between packets, as in `10us` (`ns`, `us`, `ms`); otherwise the camera's own"
    )
    bandwidth: str = _option("", "RATE", "the same as a limit in bytes per second, as in `60MB`")
    multicast: str = _option(
        "",
        "ADDRESS",
        "multicast group to send to, as in `239.192.0.1`, so that others can receive",
    )
    stream_channel: str = _option(
        "0",
        "INDEX|all",
        "the stream channel to receive, of a camera with several (`GevStreamChannelCount`): often one for "
        "each sensor. With `all` the frames of every channel arrive, and `Frame.stream_channel` names it",
    )
    plain: bool = _option(False, "0|1", "use one system call per packet, for comparison", _switch)
    pixels: str = _option(
        "auto",
        "auto|little|big",
        "byte order of pixels with more than 8 bits. `auto` follows the camera's register and its feature "
        "`DeviceStreamChannelEndianness`, and a table of cameras that announce the wrong one",
        _one_of("auto", "little", "big"),
    )
    payload_size: int = _option(
        0,
        "BYTES",
        "size of the largest frame, for a camera whose `PayloadSize` is too small; 0 is the camera's own",
        _number(0, 1 << 30, int),
    )
    registers: str = _option(
        "auto",
        "auto|memory|numbers",
        "how registers of four bytes are accessed: as `memory`, in the order that the description declares "
        "(READMEM, WRITEMEM), or as `numbers` (READREG, WRITEREG). `auto` follows the version of the "
        "description's schema and a table of cameras whose descriptions claim the wrong one",
        _one_of("auto", "memory", "numbers"),
    )


@dataclass(frozen=True)
class U3vOptions(DescriptionOption):
    """`u3v:` how transfers are requested."""

    transfer_size: int = _option(
        1 << 20,
        "BYTES",
        "largest bulk transfer, a number from 1024 to 16777216; `65536` if a controller loses data in long "
        "ones",
        _number(1024, 1 << 24, int),
    )
    transfers: int = _option(
        64,
        "COUNT",
        "transfers in flight, a number from 1 to 1024; `1` uses pyusb's synchronous calls only",
        _number(1, 1024, int),
    )


@dataclass(frozen=True)
class YarpOptions:
    """`yarp:` how the port is found and images travel."""

    carrier: str = _option(
        "fast_tcp", "CARRIER", "how images travel: `fast_tcp`, `tcp`, `udp`, `mcast`, `mjpeg`, `unix_stream`"
    )
    nameserver: str = _option("", "HOST:PORT", "another name server than the configured one")
    bind: str = _option("", "ADDRESS", "the address at which our receiving port listens")
    components: bool = _option(True, "0|1", "`0`: the first image of each frame only", _switch)


@dataclass(frozen=True)
class Ros2Options:
    """`ros2:` how images are subscribed to."""

    qos: str = _option(
        "sensor_data",
        "sensor_data|reliable",
        "quality of service: `sensor_data` is best effort",
        _one_of("sensor_data", "reliable"),
    )
    components: bool = _option(True, "0|1", "`0`: the first image of each frame only", _switch)


@dataclass(frozen=True)
class PlaybackOptions:
    """`file:` how a recording is played."""

    loop: bool = _option(True, "0|1", "start again at the end", _switch)
    speed: float = _option(
        1.0, "FACTOR", "speed, a number from 0.05 to 20; `2` is twice as fast", _number(0.05, 20)
    )
    topic: str = _option("", "NAME|all", "the images of a ROS recording; all: every topic in each frame", str)


@dataclass(frozen=True)
class TwinOptions:
    """`twin:` how a reported camera is imitated."""

    answer_times: bool = _option(
        True, "0|1", "let each register access take as long as with the original", _switch
    )


def read_options(kind: type[Options], uri: SourceUri) -> Options:
    """Return the options of a URI. Raises UsageError naming the option and its allowed values."""
    known = {row.name: row for row in option_rows(kind)}
    readers = {entry.name: entry.metadata["read"] for entry in fields(kind)}  # type: ignore[arg-type]
    values: dict[str, Any] = {}
    for name, text in uri.options.items():
        if not known:
            raise UsageError(f"{uri}: {uri.scheme}: sources have no options")
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else _there_is(known)
            raise UsageError(f"{uri}: there is no option {name}; {hint}")
        try:
            values[name] = readers[name](text)
        except ValueError:
            row = known[name]
            takes = row.form if "|" in row.form else f"{row.form}, {row.meaning}"
            raise UsageError(f"{uri}: {name}={text}: write {takes.replace('|', ' or ')}") from None
    return kind(**values)


def _there_is(known: Iterable[str]) -> str:
    names = ", ".join(known)
    return f"there are {names}" if "," in names else f"there is only {names}"


def option_rows(kind: type[Any]) -> list[OptionRow]:
    """List the options of a dataclass in their order."""
    return [
        OptionRow(entry.name, entry.metadata["form"], _text(entry.default), entry.metadata["meaning"])
        for entry in fields(kind)
    ]


def _text(default: Any) -> str:
    if isinstance(default, bool):
        return str(int(default))
    return f"{default:g}" if isinstance(default, float) else str(default)
