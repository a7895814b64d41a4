"""YARP's configuration files: where the name server is, which namespace, which key."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path

from grabbergui.config import ini, resource_finder
from grabbergui.core.errors import UsageError
from grabbergui.net.yarp.os.names import DEFAULT_PORT, Contact

DEFAULT_NAMESPACE = "/root"


def namespace() -> str:
    """The namespace, which is also the name server's own name."""
    if os.environ.get("YARP_NAMESPACE"):
        return os.environ["YARP_NAMESPACE"]
    words = _read("yarp_namespace.conf").split()
    return words[0] if words else DEFAULT_NAMESPACE


def name_server() -> Contact | None:
    """The name server that the configuration tells of."""
    name = namespace()
    file_name = "yarp.conf" if name == DEFAULT_NAMESPACE else re.sub(r"[^0-9A-Za-z]", "_", name) + ".conf"
    text = _read(file_name)
    if text.lstrip().startswith("["):
        section = _section(text, "name")
        words = [section.get("host", ""), section.get("port", str(DEFAULT_PORT))]
    else:
        words = text.split()
    if not words or not words[0]:
        return None
    return parse_address(f"{words[0]}:{words[1] if len(words) > 1 else DEFAULT_PORT}", name)


def parse_address(text: str, name: str = DEFAULT_NAMESPACE) -> Contact:
    """The server at `HOST`, `HOST:PORT` or `[HOST]:PORT`. Raises UsageError."""
    match = re.fullmatch(r"(\[[^\]]+\]|[^:\s]+)(?::(\d+))?", text.strip())
    port = int(match[2] or DEFAULT_PORT) if match else 0
    if not match or not 0 < port < 65536:
        raise UsageError(f"'{text}' is no address of a name server, write HOST:PORT")
    return Contact(name, match[1].strip("[]"), port)


def authentication_key() -> bytes | None:
    """The key of `auth.conf`; None where ports need none."""
    return _section(_read("auth.conf"), "auth").get("key", "").encode() or None


def require_authentication() -> None:
    """Raise UsageError where there is no key, so that nothing is served to whoever comes."""
    if authentication_key() is None:
        folders = ", ".join(str(folder) for folder in resource_finder.config_folders())
        raise UsageError(
            "--require-authentication: no key; write a file auth.conf with the lines `[AUTH]` and "
            f"`key SECRET` into one of {folders}, on this machine and on every peer"
        )


def _read(name: str) -> str:
    override = os.environ.get("YARP_CONF", "")
    if name == "yarp.conf" and override and Path(override).is_file():
        return Path(override).read_text(errors="replace")
    for folder in (*([Path(override)] if override else []), *resource_finder.config_folders()):
        path = folder / name
        if path.is_file():
            return path.read_text(errors="replace")
    return ""


def _section(text: str, name: str) -> Mapping[str, str]:
    """A section's values, its name and keys in small letters."""
    for section in ini.parse(text, "YARP's configuration").values():
        if section.name.lower() == name:
            return {key.lower(): value for key, value in section.values.items()}
    return {}
