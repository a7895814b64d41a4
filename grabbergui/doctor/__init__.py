"""Checks for the usual problems between a camera and the window: findings, each with its remedy.

The drivers are imported by the checks that need them: the window knows findings from its start on.
"""

from __future__ import annotations

from collections.abc import Iterator

from grabbergui.core.shared_folder import MEMORY
from grabbergui.doctor.findings import Finding
from grabbergui.doctor.gige import check_network
from grabbergui.doctor.packages import check_packages
from grabbergui.doctor.software import check_software, shared_memory
from grabbergui.doctor.usb import check_usb
from grabbergui.doctor.webcams import check_webcams


def check() -> Iterator[Finding]:
    """All checks."""
    yield from check_packages()
    yield from check_network()
    yield from check_usb()
    yield from check_webcams()
    yield from check_software()
    yield from shared_memory(MEMORY)
