"""Checks for GigE Vision: kernel settings, interfaces, cameras that cannot be reached."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from grabbergui.core.errors import GrabberError
from grabbergui.core.scheduling import REALTIME, realtime_threads_permitted
from grabbergui.doctor.findings import Finding, good, note, problem
from grabbergui.doctor.mending import as_administrator

if TYPE_CHECKING:
    from grabbergui.driver.gige.discovery import FoundDevice
    from grabbergui.driver.gige.interfaces import Interface

SYSCTL = Path("/proc/sys/net")
WANTED_RMEM = 32 * 1024 * 1024
"""Bytes; a quarter of a second of a full 1 GbE line, so that a busy moment loses nothing."""
JUMBO_MTU = 9000


def check_network() -> Iterator[Finding]:
    """The kernel settings, interfaces and cameras of GigE Vision."""
    from grabbergui.driver.gige.discovery import discover
    from grabbergui.driver.gige.interfaces import interfaces

    yield from receive_buffer(SYSCTL)
    if sys.platform == "linux" and os.cpu_count() != 1:
        yield from priority(permitted=realtime_threads_permitted())
    found = [interface for interface in interfaces() if not interface.loopback]
    yield from packet_sizes(found)
    yield from shared_networks(found)
    yield from reverse_path(SYSCTL, found)
    try:
        yield from gige_cameras(discover(1.0))
    except (GrabberError, OSError) as error:
        yield problem(f"looking for GigE Vision cameras failed: {error}", "check the network interfaces")


def receive_buffer(sysctl: Path) -> Iterator[Finding]:
    """Check the largest socket buffer that the kernel grants."""
    try:
        limit = int((sysctl / "core" / "rmem_max").read_text())
    except (OSError, ValueError):
        return
    if limit < WANTED_RMEM:
        yield note(
            f"socket buffers are limited to {limit} bytes, {limit / 125e3:.1f} ms of a 1 GbE line each; "
            "a stream takes up to 32 of them, which 10 GbE may find too few",
            f"sudo sysctl -w net.core.rmem_max={WANTED_RMEM}   (in /etc/sysctl.d to keep it)",
            as_administrator("sysctl", "-w", f"net.core.rmem_max={WANTED_RMEM}"),
        )
    else:
        yield good(f"socket buffers of up to {limit // 1024 // 1024} MiB")


def priority(*, permitted: bool) -> Iterator[Finding]:
    """Check whether threads that receive frames may be scheduled first."""
    if permitted:
        yield good(
            "GigE Vision frames are received with real-time priority: on time beside busy programs, too"
        )
    else:
        yield note(
            "GigE Vision frames are received with ordinary priority: beside busy programs they come late",
            f"echo '*  -  rtprio  {REALTIME}' | sudo tee /etc/security/limits.d/grabbergui.conf"
            "   (from the next login on)",
        )


def packet_sizes(found: Sequence[Interface]) -> Iterator[Finding]:
    """Check for jumbo frames, which save most of the processor's work."""
    for interface in found:
        if interface.mtu < JUMBO_MTU:
            yield note(
                f"{interface.name} ({interface.ip}) carries packets of {interface.mtu} bytes",
                f"for fast cameras: sudo ip link set {interface.name} mtu {JUMBO_MTU}   (switches too)",
                as_administrator("ip", "link", "set", interface.name, "mtu", str(JUMBO_MTU)),
            )
        else:
            yield good(f"{interface.name} ({interface.ip}) carries jumbo packets of {interface.mtu} bytes")


def shared_networks(found: Sequence[Interface]) -> Iterator[Finding]:
    """Check for two interfaces in one subnet: packets leave by either."""
    from grabbergui.driver.gige import reasons

    for one, other in reasons.shared_networks(found):
        yield problem(reasons.shared_text(one, other), reasons.shared_remedy(other))


def reverse_path(sysctl: Path, found: Sequence[Interface]) -> Iterator[Finding]:
    """Check the filter that drops answers from other subnets."""
    for name in ("all", *dict.fromkeys(interface.name for interface in found)):
        place = sysctl / "ipv4" / "conf" / name / "rp_filter"
        try:
            strict = place.read_text().strip() == "1"
        except OSError:
            continue
        if strict:
            yield note(
                f"the reverse path filter of {name} is strict: cameras in another subnet stay unseen",
                f"sudo sysctl -w net.ipv4.conf.{name}.rp_filter=2",
                as_administrator("sysctl", "-w", f"net.ipv4.conf.{name}.rp_filter=2"),
            )


def gige_cameras(found: Sequence[FoundDevice]) -> Iterator[Finding]:
    """List the cameras found, also those at an address that cannot be reached."""
    from grabbergui.driver.gige import reasons

    if not found:
        yield note(
            "no GigE Vision camera answers",
            f"check power and cable; {reasons.FIREWALL}",
        )
    for camera in found:
        info = camera.info()
        if camera.reachable:
            yield good(f"{info.title} at {info.address}, seen on {camera.interface.name}")
        else:
            yield problem(
                f"{info.title} has the address {info.address}, out of reach of {camera.interface.name} "
                f"({camera.interface.network})",
                "give the interface or the camera an address of the other's subnet",
            )
