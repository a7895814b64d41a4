"""Options of `grabbergui serve`, on the command line or in a file, and the addresses that are answered.

Keys are those of the reference device (`index`, `fake`, `pixelFormat`, `introspection`, `terminal`) and ours;
the command line wins over the file.
"""

from __future__ import annotations

import difflib
import ipaddress
import logging
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from grabbergui.config.ini import Section
from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SIMULATED

_Network = ipaddress.IPv4Network | ipaddress.IPv6Network


class AllowedAddresses:
    """A set of networks. Without any, everybody is allowed; this machine always is."""

    def __init__(self, networks: Iterable[_Network] = ()) -> None:
        self._networks = tuple(networks)

    @classmethod
    def parse(cls, texts: Iterable[str]) -> AllowedAddresses:
        """Read `10.0.0.0/24` and `192.168.1.7`. Raises UsageError."""
        return cls(_network(text) for text in texts)

    @property
    def everybody(self) -> bool:
        """Whether every address is allowed."""
        return not self._networks

    def allows(self, address: str, own: str = "") -> bool:
        """Whether a peer at `address` is answered; `own` is this machine's end of the connection."""
        if not self._networks or address == own:
            return True
        try:
            peer = ipaddress.ip_address(address.partition("%")[0])
        except ValueError:
            return False
        if isinstance(peer, ipaddress.IPv6Address) and peer.ipv4_mapped:
            peer = peer.ipv4_mapped
        return peer.is_loopback or any(peer in network for network in self._networks)

    @property
    def hosts(self) -> list[str] | None:
        """The single addresses; None if a network is allowed, whose addresses are too many to list."""
        if any(network.num_addresses > 1 for network in self._networks):
            return None
        return [str(network.network_address) for network in self._networks]

    def __str__(self) -> str:
        return ", ".join(map(str, self._networks)) or "everybody"


EVERYBODY = AllowedAddresses()


def _network(text: str) -> _Network:
    try:
        return ipaddress.ip_network(text.strip(), strict=False)
    except ValueError as error:
        raise UsageError(f"--allow {text}: write an address or a network, as 10.0.0.0/24") from error


log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ServeOptions:
    """One camera and how it is shared."""

    source: str = ""
    "A URI; empty means the first GigE Vision camera, or the simulated one with `fake`."
    fake: bool = False
    index: int = 0
    "Number of the camera among those found, if no source is named."
    monitor: bool = False
    "Only monitor, while another application controls the camera."
    pixel_format: str = ""
    "Set before streaming."
    introspection: bool = False
    "Log every feature with its value and range when the camera is open."
    terminal: bool = False
    window: bool = False
    yarp: str = ""
    "The image port's name; empty: not on YARP."
    ros2: str = ""
    "The node's name; empty: not on ROS 2."
    frame_id: str = "camera"
    "Frame id in the headers of ROS 2 images."
    calibration: str = ""
    "A camera_info YAML file for both networks; `set_camera_info` of ROS 2 writes it."
    qos: str = "reliable"
    "Of ROS 2 images: reliable, or sensor_data (best effort)."
    with_name_server: bool = False
    "Run a YARP name server too."
    nameserver: str = ""
    "HOST:PORT of the YARP name server; empty: found as YARP does."
    bind: str = ""
    "The address our YARP ports listen on; empty: where the name server is reachable from."
    capabilities: str = "COLOR"
    "COLOR or RAW: what the YARP image port sends."
    raw: bool = False
    "Send raw images on a second YARP port as well."
    period: float = 0.0
    "Seconds between YARP images at least; 0: every frame."
    normalised: bool = False
    "Serve YARP feature values as 0…1."
    read_only: bool = False
    "Let peers on the networks see images and values, and change nothing."
    allow: str = ""
    "Addresses and networks, separated by commas or blanks, whose YARP ports and browsers are answered."
    require_authentication: bool = False
    "Serve on YARP only with a key in auth.conf, which every peer must prove to know."
    metrics_token: str = ""
    "A file with the token that whoever reads the counters must send."
    lost_timeout: float = 0.0
    "Seconds after which a source that was lost is given up; 0: never."
    metrics: str = ""
    "HOST:PORT, or PORT on this machine only, where the counters are for Prometheus; empty: nowhere."

    def __post_init__(self) -> None:
        for name in ("period", "lost_timeout"):
            seconds = getattr(self, name)
            if not 0 <= seconds < math.inf:
                raise UsageError(f"{name.replace('_', '-')} {seconds:g}: write seconds, from 0 on")

    @property
    def allowed(self) -> AllowedAddresses:
        """The addresses that are answered. Raises UsageError."""
        return AllowedAddresses.parse(self.allow.replace(",", " ").split())

    @property
    def uri(self) -> str:
        """The source to open, if it is known without a search for cameras."""
        return self.source or (SIMULATED if self.fake else "")

    def with_file(self, section: Section, given: frozenset[str], where: str) -> ServeOptions:
        """These options with a file's values for those not in `given` (the command line's).

        An unknown key is warned of, with the nearest known one. Raises UsageError for a bad value.
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


_TYPES: Mapping[str, str] = {field.name: str(field.type) for field in fields(ServeOptions)}
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
"""Maps a file's keys to our fields."""

_YARP_OWN = frozenset({"device", "subdevice", "from", "context", "verbose", "wrapper"})
"""Keys that YARP's own tools read from the same files."""


def _value(key: str, text: str, kind: str, where: str) -> Any:
    converters: dict[str, Callable[[str], Any]] = {"int": int, "float": float, "bool": _switch}
    try:
        return converters.get(kind, str)(text)
    except ValueError:
        wanted = {"int": "a whole number", "float": "a number", "bool": "yes or no"}[kind]
        raise UsageError(f"{where}: {key} {text}: write {wanted}") from None


def _switch(text: str) -> bool:
    """A key alone means yes."""
    lowered = text.lower()
    if lowered in ("", "1", "true", "on", "yes"):
        return True
    if lowered in ("0", "false", "off", "no"):
        return False
    raise ValueError(text)
