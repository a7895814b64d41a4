"""The udev rule that lets users open USB3 Vision cameras."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from grabbergui.core.environment import RESOURCES, sudo_command
from grabbergui.core.errors import AccessDeniedError

RULE_NAME = "70-grabbergui-u3v.rules"
RULE = RESOURCES / "udev" / RULE_NAME
RULES = Path("/etc/udev/rules.d")


def installed_rule(folder: Path = RULES, packaged: Path = Path("/usr/lib/udev/rules.d")) -> Path | None:
    """Return the installed rule, of this user's system or of a package; None without one."""
    for place in (folder / RULE_NAME, packaged / RULE_NAME):
        if place.is_file():
            return place
    return None


def install(folder: Path = RULES) -> Path:
    """Write the rule and let udev read it; return where it is. Raises AccessDeniedError for who may not."""
    target = folder / RULE_NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        target.write_text(RULE.read_text("utf-8"), "utf-8")
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be written by this user; run: {sudo_command('setup', 'udev')}"
        ) from error
    _reload()
    return target


def remove(folder: Path = RULES) -> Path | None:
    """Remove the rule and let udev know; return where it was, None where there was none.

    Raises AccessDeniedError for who may not.
    """
    target = folder / RULE_NAME
    try:
        target.unlink()
    except FileNotFoundError:
        return None
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be removed by this user; run: {sudo_command('setup', 'udev', '--remove')}"
        ) from error
    _reload()
    return target


def _reload() -> None:
    udevadm = shutil.which("udevadm")
    if udevadm is not None:
        for arguments in (["control", "--reload"], ["trigger", "--subsystem-match=usb"]):
            # A container has no udev to notify; the rule is in place all the same.
            subprocess.run([udevadm, *arguments], check=False, capture_output=True, timeout=10)
