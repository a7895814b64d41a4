"""The options of `grabbergui serve`, from the command line and from a file, which has less precedence.

`ServeOptions` lists each option once, for both: the command line has it as `--read-only`, a file as the key
`read-only` or `read_only`. Some keys have the names that the reference device gives them (`pixelFormat`).
"""

from __future__ import annotations

import difflib
import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

from grabbergui.config.allowed_addresses import AllowedAddresses
from grabbergui.config.ini_files import IniSection
from grabbergui.core.errors import UsageError
from grabbergui.core.features import parse_switch
from grabbergui.core.uri import SIMULATED

log = logging.getLogger(__name__)
_YARP_OWN = frozenset({"device", "subdevice", "from", "context", "verbose", "wrapper"})
"""Keys that YARP's own tools read from the same files."""


def _option(
    default: Any, meaning: str, *, form: str = "", needs: str = "", key: str = "", choices: Sequence[str] = ()
) -> Any:
    """Return a dataclass field.

    `form` shows the value in `--help`; an option with `needs` has no effect without that network. `key` is
    another name of it in files.
    """
    return field(
        default=default,
        metadata={"meaning": meaning, "form": form, "needs": needs, "key": key, "choices": tuple(choices)},
    )


@dataclass(frozen=True)
class ServeOptions:
    """The options of `grabbergui serve` for a camera, in the order of `--help`."""

    source: str = ""
    "A URI; empty for the first GigE Vision camera, or the simulated one with `fake`."
    fake: bool = _option(False, "serve the simulated camera")
    index: int = _option(0, "which of the cameras found, if no SOURCE is given", form="N")
    monitor: bool = False
    "Only monitor, while another application controls the camera."
    lost_timeout: float = 0.0
    "Seconds after which a lost source is given up; 0 for never."
    pixel_format: str = _option("", "set PixelFormat before streaming", form="NAME", key="pixelFormat")
    introspection: bool = _option(False, "log every feature of the camera")
    terminal: bool = _option(False, "take commands from the keyboard")
    window: bool = _option(False, "open the window, too")
    metrics: str = _option(
        "",
        "serve counters to Prometheus at http://HOST:PORT/metrics (HOST: 127.0.0.1)",
        form="[HOST:]PORT",
    )
    metrics_token: str = _option(
        "", "a file with the bearer token that clients of the counters must send", form="FILE"
    )
    read_only: bool = _option(False, "let peers see everything and change nothing")
    allow: str = ""
    "Addresses and networks, separated by commas or spaces, whose YARP ports and browsers are answered."
    calibration: str = _option(
        "",
        "camera_info YAML, for ROS 2's camera_info and YARP's intrinsics; set_camera_info writes it",
        form="FILE",
    )
    yarp: str = _option("", "the port of the images; requests go to /PORT/rpc", form="/PORT", key="name")
    with_name_server: bool = False
    "Run a YARP name server too."
    nameserver: str = ""
    "HOST:PORT of the YARP name server; empty to find it as YARP does."
    require_authentication: bool = _option(
        False, "refuse to start without a key in YARP's auth.conf", needs="yarp"
    )
    bind: str = _option("", "the address that the ports listen on", form="ADDRESS", needs="yarp")
    capabilities: str = _option("COLOR", "what the image port sends", choices=("COLOR", "RAW"), needs="yarp")
    raw: bool = _option(False, "also send raw images, at /PORT/raw", needs="yarp")
    period: float = _option(0.0, "least time between images in seconds", form="S", needs="yarp")
    normalised: bool = _option(False, "serve feature values as 0…1 instead of in their units", needs="yarp")
    ros2: str = _option("", "the node's name, which prefixes its topics", form="/NAME", key="node_name")
    frame_id: str = _option("camera", "frame_id of the images' headers", form="FRAME", needs="ros2")
    qos: str = _option(
        "reliable",
        "quality of service of the images; sensor_data: best effort",
        choices=("reliable", "sensor_data"),
        needs="ros2",
    )
    lifecycle: bool = _option(
        False, "a managed node, which sends once `ros2 lifecycle set` has activated it", needs="ros2"
    )

    def __post_init__(self) -> None:
        for name in ("period", "lost_timeout"):
            seconds = getattr(self, name)
            if not 0 <= seconds < math.inf:
                raise UsageError(f"{name.replace('_', '-')} {seconds:g}: write seconds, from 0 on")

    @property
    def allowed(self) -> AllowedAddresses:
        """The addresses whose requests are answered. Raises UsageError."""
        return AllowedAddresses.parse(self.allow.replace(",", " ").split())

    @property
    def uri(self) -> str:
        """The source to open; empty if cameras must be searched first."""
        return self.source or (SIMULATED if self.fake else "")

    def with_file(self, section: IniSection, given: frozenset[str], where: str) -> ServeOptions:
        """Return the options with a file's values for those not in `given` (by the command line).

        Logs a warning for an unknown key, with the most similar known one. Raises UsageError for a bad value.
        """
        changes: dict[str, Any] = {}
        for key, text in section.values.items():
            name = _NAMES.get(key)
            if name is None:
                if key not in _YARP_OWN:
                    near = difflib.get_close_matches(key, _NAMES, n=1)
                    hint = f"; did you mean {near[0]}?" if near else ""
                    log.warning("%s: unknown key %r is ignored%s", where, key, hint)
            elif name not in given:
                changes[name] = _value(key, text, _TYPES[name], where)
        return replace(self, **changes)


_TYPES: Mapping[str, str] = {each.name: str(each.type) for each in fields(ServeOptions)}
_NAMES: Mapping[str, str] = {
    key: each.name
    for each in fields(ServeOptions)
    for key in (each.name, each.name.replace("_", "-"), each.metadata.get("key"))
    if key
}
"""The field of each key of a file."""


def _value(key: str, text: str, kind: str, where: str) -> Any:
    converters: dict[str, Callable[[str], Any]] = {
        "int": int,
        "float": float,
        "bool": lambda text: parse_switch(text or "1"),  # a key without a value means yes
    }
    try:
        return converters.get(kind, str)(text)
    except ValueError:
        wanted = {"int": "a whole number", "float": "a number", "bool": "yes or no"}[kind]
        raise UsageError(f"{where}: {key} {text}: write {wanted}") from None
