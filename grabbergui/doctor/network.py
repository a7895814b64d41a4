"""Checks for GigE Vision: kernel settings, interfaces, cameras that cannot be reached."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path

from grabbergui.core.errors import GrabberError
from grabbergui.doctor.finding import Finding, good, note, problem
from grabbergui.driver.gige.discovery import search
from grabbergui.driver.gige.discovery.interfaces import Interface, interfaces
from grabbergui.driver.gige.discovery.search import FoundDevice

SYSCTL = Path("/proc/sys/net")
WANTED_RMEM = 32 * 1024 * 1024
"""Bytes; a quarter of a second of a full 1 GbE line, so that a busy moment loses nothing."""
JUMBO_MTU = 9000


def check() -> Iterator[Finding]:
    """All checks of this kind."""
    yield from receive_buffer(SYSCTL)
    found = [interface for interface in interfaces() if not interface.loopback]
    yield from packet_sizes(found)
    yield from shared_networks(found)
    yield from reverse_path(SYSCTL, found)
    try:
        yield from cameras(search.discover(1.0))
    except (GrabberError, OSError) as error:
        yield problem(f"looking for GigE Vision cameras failed: {error}", "check the network interfaces")


def receive_buffer(sysctl: Path) -> Iterator[Finding]:
    """The largest socket buffer that the kernel grants."""
    try:
        limit = int((sysctl / "core" / "rmem_max").read_text())
    except (OSError, ValueError):
        return
    if limit < WANTED_RMEM:
        yield note(
            f"socket buffers are limited to {limit} bytes, {limit / 125e3:.1f} ms of a 1 GbE line each; "
            "a stream takes up to 32 of them, which 10 GbE may find too few",
            f"sudo sysctl -w net.core.rmem_max={WANTED_RMEM}   (in /etc/sysctl.d to keep it)",
        )
    else:
        yield good(f"socket buffers of up to {limit // 1024 // 1024} MiB")


def packet_sizes(found: Sequence[Interface]) -> Iterator[Finding]:
    """Jumbo frames, which spare the processor most of its work."""
    for interface in found:
        if interface.mtu < JUMBO_MTU:
            yield note(
                f"{interface.name} ({interface.ip}) carries packets of {interface.mtu} bytes",
                f"for fast cameras: sudo ip link set {interface.name} mtu {JUMBO_MTU}   (switches too)",
            )
        else:
            yield good(f"{interface.name} ({interface.ip}) carries jumbo packets of {interface.mtu} bytes")


def shared_networks(found: Sequence[Interface]) -> Iterator[Finding]:
    """Two interfaces in one subnet: packets leave by either."""
    for one, other in combinations(found, 2):
        if one.name != other.name and one.network.overlaps(other.network):
            yield problem(
                f"{one.name} ({one.ip}) and {other.name} ({other.ip}) are in one subnet, {one.network}; "
                "the system may use the wrong one for a camera",
                f"give {other.name} and its cameras addresses of another subnet",
            )


def reverse_path(sysctl: Path, found: Sequence[Interface]) -> Iterator[Finding]:
    """The filter that drops answers from other subnets."""
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
            )


def cameras(found: Sequence[FoundDevice]) -> Iterator[Finding]:
    """Cameras seen, and those that answer from an address that cannot be reached."""
    if not found:
        yield note(
            "no GigE Vision camera answers",
            "check power and cable; a firewall must let UDP in: sudo ufw allow proto udp from any port 3956",
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
