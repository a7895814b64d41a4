"""YARP's configuration files: where the name server is, which namespace, which key."""

from __future__ import annotations

import configparser
import os
import re
import sys
from pathlib import Path

from grabbergui.core.errors import UsageError
from grabbergui.net.yarp.os.names import DEFAULT_PORT, Contact

DEFAULT_NAMESPACE = "/root"


def folders() -> list[Path]:
    """Where YARP looks, first to last."""
    env = os.environ
    found = [Path(env[name]) for name in ("YARP_CONFIG_HOME", "YARP_CONF") if env.get(name)]
    if env.get("XDG_CONFIG_HOME"):
        found.append(Path(env["XDG_CONFIG_HOME"]) / "yarp")
    elif sys.platform == "win32":
        found.append(Path(env.get("APPDATA", "")) / "yarp" / "config")
    elif sys.platform == "darwin":
        found.append(Path.home() / "Library" / "Preferences" / "yarp")
    found.append(Path.home() / ".config" / "yarp")
    found += [Path(folder) / "yarp" for folder in env.get("XDG_CONFIG_DIRS", "/etc/xdg").split(":")]
    return found


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
        section = _sections(text).get("name", {})
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
    key = _sections(_read("auth.conf")).get("auth", {}).get("key", "").strip().strip('"')
    return key.encode() or None


def _read(name: str) -> str:
    override = os.environ.get("YARP_CONF", "")
    if name == "yarp.conf" and override and Path(override).is_file():
        return Path(override).read_text(errors="replace")
    for folder in folders():
        path = folder / name
        if path.is_file():
            return path.read_text(errors="replace")
    return ""


def _sections(text: str) -> dict[str, dict[str, str]]:
    # YARP's files separate key and value by a blank, = or both; they may begin without a section.
    lines = [re.sub(r"^\s*([\w.]+)[ \t]*=?[ \t]+", r"\1 = ", line) for line in text.splitlines()]
    parser = configparser.ConfigParser(interpolation=None, strict=False, allow_no_value=True)
    try:
        parser.read_string("[DEFAULT]\n" + "\n".join(lines))
    except configparser.Error as error:
        raise UsageError(f"a YARP configuration file cannot be read: {error}") from error
    return {name.lower(): {k: v or "" for k, v in parser.items(name)} for name in parser.sections()}
