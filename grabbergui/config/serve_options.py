"""The options of `grabbergui serve`, from the command line and from a file, which has less precedence.

`serve` has its own keys and those of the reference device (`index`, `fake`, `pixelFormat`, `introspection`,
`terminal`).
"""

from __future__ import annotations

import difflib
import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from grabbergui.config.allowed_addresses import AllowedAddresses
from grabbergui.config.ini_files import IniSection
from grabbergui.core.errors import UsageError
from grabbergui.core.features import parse_switch
from grabbergui.core.uri import SIMULATED

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ServeOptions:
    """The options of `grabbergui serve` for a camera."""

    source: str = ""
    "A URI; empty for the first GigE Vision camera, or the simulated one with `fake`."
    fake: bool = False
    index: int = 0
    "Number of the camera among those found, if no source is given."
    monitor: bool = False
    "Only monitor, while another application controls the camera."
    pixel_format: str = ""
    "PixelFormat to set before streaming."
    introspection: bool = False
    "Log every feature with its value and range when the camera is open."
    terminal: bool = False
    window: bool = False
    yarp: str = ""
    "The image port's name; empty to not serve on YARP."
    ros2: str = ""
    "The node's name; empty to not serve on ROS 2."
    frame_id: str = "camera"
    "Frame id in the headers of ROS 2 images."
    calibration: str = ""
    "A camera_info YAML file for both networks; `set_camera_info` of ROS 2 writes it."
    qos: str = "reliable"
    "QoS of ROS 2 images: reliable, or sensor_data (best effort)."
    with_name_server: bool = False
    "Run a YARP name server too."
    nameserver: str = ""
    "HOST:PORT of the YARP name server; empty to find it as YARP does."
    bind: str = ""
    "Address on which the YARP ports listen; empty for the one that reaches the name server."
    capabilities: str = "COLOR"
    "COLOR or RAW images on the YARP image port."
    raw: bool = False
    "Send raw images on a second YARP port as well."
    period: float = 0.0
    "Least seconds between YARP images; 0 for every frame."
    normalised: bool = False
    "Serve YARP feature values as 0…1."
    read_only: bool = False
    "Let peers on the networks read images and values, but change nothing."
    allow: str = ""
    "Addresses and networks, separated by commas or spaces, whose YARP ports and browsers are answered."
    require_authentication: bool = False
    "Serve on YARP only with a key in auth.conf, which every peer must prove to know."
    metrics_token: str = ""
    "A file with the token that a reader of the counters must send."
    lost_timeout: float = 0.0
    "Seconds after which a lost source is given up; 0 for never."
    metrics: str = ""
    "HOST:PORT, or PORT on this computer only, that serves the counters to Prometheus; empty for none."

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
_NAMES: Mapping[str, str] = {name: name for name in _TYPES if name != "pixel_format"} | {
    "pixelFormat": "pixel_format",
    "with-name-server": "with_name_server",
    "read-only": "read_only",
    "require-authentication": "require_authentication",
    "metrics-token": "metrics_token",
    "lost-timeout": "lost_timeout",
    "name": "yarp",
    "node_name": "ros2",
}
"""The field of each key of a file."""

_YARP_OWN = frozenset({"device", "subdevice", "from", "context", "verbose", "wrapper"})
"""Keys that YARP's own tools read from the same files."""


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
