"""The udev rule, which lets users open USB3 Vision cameras."""

from __future__ import annotations

import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

from grabbergui.core.environment import RESOURCES, sudo_command
from grabbergui.core.errors import AccessDeniedError

UDEV_RULE_NAME = "70-grabbergui-u3v.rules"
UDEV_RULE = RESOURCES / "udev" / UDEV_RULE_NAME
UDEV_RULES = Path("/etc/udev/rules.d")
_PACKAGED_UDEV_RULES = Path("/usr/lib/udev/rules.d")
_UDEV_TIME = 10.0
"""Seconds that udev may take to read its rules."""


def installed_udev_rule(folder: Path) -> Path | None:
    """Return the rule that is installed in `folder` or by a package; None without one."""
    places = (folder / UDEV_RULE_NAME, _PACKAGED_UDEV_RULES / UDEV_RULE_NAME)
    return next((place for place in places if place.is_file()), None)


def install_udev_rule(folder: Path = UDEV_RULES) -> Path:
    """Write the rule and let udev read it; return its path. Raises AccessDeniedError."""
    target = folder / UDEV_RULE_NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        target.write_text(UDEV_RULE.read_text("utf-8"), "utf-8")
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be written by this user; run: {sudo_command('setup', 'udev')}"
        ) from error
    _reload_udev()
    return target


def remove_udev_rule() -> Path | None:
    """Remove the rule and let udev know; return where it was, None where there was none.

    Raises AccessDeniedError.
    """
    target = UDEV_RULES / UDEV_RULE_NAME
    try:
        target.unlink()
    except FileNotFoundError:
        return None
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be removed by this user; run: {sudo_command('setup', 'udev', '--remove')}"
        ) from error
    _reload_udev()
    return target


def _reload_udev() -> None:
    udevadm = shutil.which("udevadm")
    if udevadm is not None:
        for arguments in (["control", "--reload"], ["trigger", "--subsystem-match=usb"]):
            # A container has no udev to notify, or one that hangs; the rule is in place all the same.
            with suppress(subprocess.TimeoutExpired):
                subprocess.run([udevadm, *arguments], check=False, capture_output=True, timeout=_UDEV_TIME)
