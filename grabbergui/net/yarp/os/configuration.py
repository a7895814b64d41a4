"""YARP's configuration: namespace, address of the name server, authentication key."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path

from grabbergui.config.ini_files import config_folders, parse_ini
from grabbergui.core.errors import (
    SourceUnavailableError,
    UsageError,
)
from grabbergui.core.regular_files import read_bounded
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.port_environment import safe_name

_MAX_BYTES = 1 << 20
"Bytes of the largest file of YARP's configuration."
DEFAULT_HOST, DEFAULT_PORT = "127.0.0.1", 10000
DEFAULT_NAMESPACE = "/root"


def namespace() -> str:
    """Return the namespace, which is also the name server's own name; the first of several."""
    words = (os.environ.get("YARP_NAMESPACE") or _read("yarp_namespace.conf")).split()
    return words[0] if words else DEFAULT_NAMESPACE


def name_server() -> Contact | None:
    """Return the name server that the configuration names. Raises UsageError if it names none properly."""
    name = namespace()
    file_name = "yarp.conf" if name == DEFAULT_NAMESPACE else safe_name(name) + ".conf"
    text = _read(file_name)
    if not text.strip():
        return None
    if text.lstrip().startswith("["):
        section = _section(text, "name")
        host, port = section.get("host", ""), section.get("port", str(DEFAULT_PORT))
    else:
        host, port = [*text.split(), str(DEFAULT_PORT)][:2]
    try:
        return parse_address(f"{host}:{port}", name)
    except UsageError as error:
        problem = f"'{host} {port}' is no address of a name server; `yarp conf HOST PORT` writes one"
        raise UsageError(f"{_path(file_name)}: {problem}") from error


def parse_address(text: str, name: str = DEFAULT_NAMESPACE) -> Contact:
    """Return the server at `HOST`, `HOST:PORT` or `[HOST]:PORT`. Raises UsageError."""
    match = re.fullmatch(r"(\[[^\]]+\]|[^:\s]+)(?::(\d{1,5}))?", text.strip())
    port = int(match[2] or DEFAULT_PORT) if match else 0
    if not match or not 0 < port < 65536:
        raise UsageError(f"'{text}' is no address of a name server, write HOST:PORT")
    return Contact(name, match[1].strip("[]"), port)


def authentication_key() -> bytes | None:
    """Return the key of `auth.conf`; None where ports need none."""
    return _section(_read("auth.conf"), "auth").get("key", "").encode() or None


def require_authentication() -> None:
    """Raise UsageError if there is no key, so that no port is open to everybody."""
    if authentication_key() is None:
        folders = ", ".join(str(folder) for folder in config_folders())
        raise UsageError(
            "--require-authentication: no key; write a file auth.conf with the lines `[AUTH]` and "
            f"`key SECRET` into one of {folders}, on this machine and on every peer"
        )


def _path(name: str) -> Path | None:
    """Return the place of a file of YARP's configuration. Raises SourceUnavailableError."""
    for path in (folder / name for folder in config_folders()):
        try:
            if path.is_file():
                return path
        except OSError as error:
            raise _unreadable(path, error) from error
    return None


def _read(name: str) -> str:
    """Return the text of a file of YARP's configuration; empty without one. Raises SourceUnavailableError."""
    path = _path(name)
    try:
        return read_bounded(path, _MAX_BYTES, "file of YARP").decode("utf-8", "replace") if path else ""
    except OSError as error:
        raise _unreadable(path, error) from error
    except UsageError as error:
        raise SourceUnavailableError(str(error)) from error


def _unreadable(path: Path | None, error: OSError) -> SourceUnavailableError:
    """Return the error to raise. A key that cannot be read must not mean that none is needed."""
    return SourceUnavailableError(f"{path} could not be read: {error.strerror or error}")


def _section(text: str, name: str) -> Mapping[str, str]:
    """Return a section's values, its name and keys in small letters."""
    for section in parse_ini(text, "YARP's configuration").values():
        if section.name.lower() == name:
            return {key.lower(): value for key, value in section.values.items()}
    return {}
