"""Checks for webcams and other video devices of Linux."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

from grabbergui.core.environment import shell_command
from grabbergui.doctor.findings import Finding, good, note, problem

DEVICES = Path("/dev")


def check_webcams() -> Iterator[Finding]:
    """The video devices, and whether they may be opened."""
    if sys.platform == "linux":
        yield from webcams(DEVICES)
    else:
        yield note(
            "webcams (v4l2:) are supported on Linux only",
            f"{shell_command('gui', 'sim:')}, a simulated camera, runs everywhere",
        )


def webcams(folder: Path) -> Iterator[Finding]:
    """Check the video devices in a folder like `/dev`."""
    devices = sorted(folder.glob("video*"))
    denied = [device for device in devices if not os.access(device, os.R_OK | os.W_OK)]
    if not devices:
        yield note(
            "no webcam is plugged in, nor another camera of the system (/dev/video*)",
            f"{shell_command('gui', 'sim:')}, a simulated camera on which everything can be tried;"
            f" {shell_command('simulate', '--gige', '127.0.0.5')} puts one on the network",
        )
    elif denied:
        yield problem(
            f"{', '.join(map(str, denied))} may not be opened by this user",
            "sudo usermod -aG video $USER, then log in again",
        )
    else:
        from grabbergui.driver.v4l2.finding import find

        for info in find() if folder == DEVICES else []:
            yield good(f"{info.title} at {info.address}: {shell_command('gui', info.uri)} opens it")
