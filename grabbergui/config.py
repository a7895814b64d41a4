"""Configuration: YARP's `.ini` files, and the options of `grabbergui serve` in them.

The `.ini` dialect has `key value` lines in `[sections]`. A value is the rest of the line after the key,
without surrounding quotes. Lines starting with `//` or `#` are comments. A section may begin with
`[group name]`, which YARP uses for lists of groups; both words are then its name.

A file is looked for in the current folder; then, if there is a context, in `contexts/<context>` of the
configuration home, the data home, and the system's configuration and data folders; then in those folders
themselves. The environment variables are YARP's: YARP_CONFIG_HOME, YARP_DATA_HOME, YARP_CONFIG_DIRS,
YARP_DATA_DIRS (colon-separated).

`serve` has its own keys and those of the reference device (`index`, `fake`, `pixelFormat`, `introspection`,
`terminal`); the command line takes precedence over the file. `AllowedAddresses` decides whose requests are
answered.
"""

from __future__ import annotations

import difflib
import ipaddress
import logging
import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from grabbergui.core.errors import UsageError
from grabbergui.core.features import parse_switch
from grabbergui.core.regular_files import read_bounded
from grabbergui.core.uri import SIMULATED

log = logging.getLogger(__name__)

# -- .ini files ----------------------------------------------------------------------------------
_ENTRY = re.compile(r"([^\s=]+)(?:\s*=\s*|\s+|$)(.*)")
"""`key value`, or `key = value` as in other dialects."""
_MAX_BYTES = 1024 * 1024
"""Largest size of a configuration file."""


@dataclass
class Section:
    """The keys of one section, in order."""

    name: str
    "Empty for the keys before the first section."
    values: dict[str, str] = field(default_factory=dict)


MAX_INI_BYTES = 1 << 20


def read_ini(path: Path) -> str:
    """Return the text of a file for `parse_ini`. Raises UsageError, OSError."""
    return read_bounded(path, MAX_INI_BYTES, ".ini file").decode("utf-8", "replace")


def parse_ini(text: str, where: str = "configuration") -> dict[str, Section]:
    """Read a file's text. Raises UsageError naming `where` and the line."""
    if len(text) > _MAX_BYTES:
        raise UsageError(f"{where}: {len(text)} bytes is too long for a configuration")
    sections = {"": Section("")}
    current = sections[""]
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith(("//", "#", ";")):
            continue
        if line.startswith("["):
            if not line.endswith("]") or not line[1:-1].strip():
                raise UsageError(f"{where}, line {number}: '{line}' is no section; write [name]")
            name = " ".join(line[1:-1].split())
            current = sections.setdefault(name, Section(name))
            continue
        match = _ENTRY.fullmatch(line)
        if not match:
            raise UsageError(f"{where}, line {number}: '{line}' has no key; write: key value")
        current.values[match[1]] = _unquoted(match[2])
    return sections


def _unquoted(value: str) -> str:
    if len(value) >= 2 and value[0] == value[-1] and value[0] in "\"'":
        return value[1:-1]
    return value


def find_ini(name: str, context: str = "", environment: Mapping[str, str] = os.environ) -> Path:
    """Return the first file of this name, or an absolute path itself. Raises UsageError with the folders."""
    if Path(name).is_absolute():
        folders = [Path("/")]
    else:
        folders = list(dict.fromkeys(_search_path(context, environment)))
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    looked = ", ".join(str(folder) for folder in folders)
    raise UsageError(f"there is no configuration file {name}; looked in {looked}")


def _search_path(context: str = "", environment: Mapping[str, str] = os.environ) -> Iterator[Path]:
    """Yield the folders in order; they need not exist."""
    yield Path.cwd()
    config_home, *config_dirs = config_folders(environment)
    homes = [
        config_home,
        _folder(environment, "YARP_DATA_HOME", "XDG_DATA_HOME", ".local/share"),
        *config_dirs,
        *_folders(environment, "YARP_DATA_DIRS", "XDG_DATA_DIRS", "/usr/local/share:/usr/share"),
    ]
    if context:
        yield from (home / "contexts" / context for home in homes)
    yield from homes


def config_folders(environment: Mapping[str, str] = os.environ) -> list[Path]:
    """Return the user's configuration folder, then the system's."""
    home = {"win32": "AppData/Roaming", "darwin": "Library/Preferences"}.get(sys.platform, ".config")
    return [
        _folder(environment, "YARP_CONFIG_HOME", "XDG_CONFIG_HOME", home),
        *_folders(environment, "YARP_CONFIG_DIRS", "XDG_CONFIG_DIRS", "/etc/xdg"),
    ]


def _folder(environment: Mapping[str, str], yarp: str, xdg: str, below_home: str) -> Path:
    if environment.get(yarp):
        return Path(environment[yarp])
    if environment.get(xdg):
        return Path(environment[xdg]) / "yarp"
    return Path(environment.get("HOME") or "/") / below_home / "yarp"


def _folders(environment: Mapping[str, str], yarp: str, xdg: str, default: str) -> list[Path]:
    if environment.get(yarp):
        return [Path(part) for part in environment[yarp].split(":") if part]
    return [Path(part) / "yarp" for part in (environment.get(xdg) or default).split(":") if part]


# -- options of serve ----------------------------------------------------------------------------
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

    def with_file(self, section: Section, given: frozenset[str], where: str) -> ServeOptions:
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


# -- allowed addresses ---------------------------------------------------------------------------
_Network = ipaddress.IPv4Network | ipaddress.IPv6Network
_MAPPED_PREFIX = 96
"""Bits before the IPv4 address in an IPv6 one such as `::ffff:10.0.0.1`."""


class AllowedAddresses:
    """A set of networks. Without any, every address is allowed; this computer is always allowed."""

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
        """Return whether a peer at `address` is allowed; `own` is the local address of the connection."""
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
        """The single addresses; None if a network is allowed, which has too many to list."""
        if any(network.num_addresses > 1 for network in self._networks):
            return None
        return [str(network.network_address) for network in self._networks]

    def __str__(self) -> str:
        return ", ".join(map(str, self._networks)) or "everybody"


EVERYBODY = AllowedAddresses()


def _network(text: str) -> _Network:
    try:
        network = ipaddress.ip_network(text.strip(), strict=False)
    except ValueError as error:
        raise UsageError(f"--allow {text}: write an address or a network, as 10.0.0.0/24") from error
    mapped = network.network_address.ipv4_mapped if isinstance(network, ipaddress.IPv6Network) else None
    if mapped and network.prefixlen >= _MAPPED_PREFIX:
        return ipaddress.IPv4Network((mapped, network.prefixlen - _MAPPED_PREFIX))
    return network
