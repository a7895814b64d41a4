"""Checks for the usual problems between a camera and the window: findings, each with its remedy.

GigE Vision: kernel settings, interfaces, cameras that cannot be reached. USB3 Vision: permissions and memory
of the kernel for transfers. Software: the display of the window, YARP, ROS 2 and what it left in memory.

The drivers are imported by the checks that need them: the window knows findings from its start on.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from grabbergui.core.environment import shell_command, sudo_command
from grabbergui.core.errors import GrabberError
from grabbergui.core.scheduling import REALTIME, realtime_threads_permitted
from grabbergui.core.shared_folder import MEMORY
from grabbergui.setup.parts import UDEV_RULES, installed_udev_rule

if TYPE_CHECKING:
    from grabbergui.driver.gige.discovery import FoundDevice, Interface


# -- findings ------------------------------------------------------------------------------------
class Level(Enum):
    """Severity of a finding."""

    GOOD = "ok"
    NOTE = "note"
    "Something optional is missing."
    PROBLEM = "problem"


@dataclass(frozen=True)
class Finding:
    """One line of the report, and its remedy."""

    level: Level
    text: str
    remedy: str = ""
    "A command or a sentence; empty if nothing need be done."


def good(text: str) -> Finding:
    """Return a finding without anything to do."""
    return Finding(Level.GOOD, text)


def note(text: str, remedy: str = "") -> Finding:
    """Return a finding about something optional."""
    return Finding(Level.NOTE, text, remedy)


def problem(text: str, remedy: str) -> Finding:
    """Return a finding about a problem."""
    return Finding(Level.PROBLEM, text, remedy)


def check() -> Iterator[Finding]:
    """All checks."""
    yield from check_network()
    yield from check_usb()
    yield from check_software()
    yield from shared_memory(MEMORY)


# -- GigE Vision ---------------------------------------------------------------------------------
SYSCTL = Path("/proc/sys/net")
WANTED_RMEM = 32 * 1024 * 1024
"""Bytes; a quarter of a second of a full 1 GbE line, so that a busy moment loses nothing."""
JUMBO_MTU = 9000


def check_network() -> Iterator[Finding]:
    """The kernel settings, interfaces and cameras of GigE Vision."""
    from grabbergui.driver.gige.discovery import discover, interfaces

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


# -- USB3 Vision ---------------------------------------------------------------------------------
USBFS_MEMORY = Path("/sys/module/usbcore/parameters/usbfs_memory_mb")
WANTED_USBFS_MB = 256
"""Eight frames of 32 MB in flight."""


def check_usb() -> Iterator[Finding]:
    """The udev rule, transfer memory and cameras of USB3 Vision."""
    yield from udev_rule(UDEV_RULES)
    yield from transfer_memory(USBFS_MEMORY)
    yield from usb_cameras()


def udev_rule(folder: Path) -> Iterator[Finding]:
    """Check whether users may open cameras."""
    rule = installed_udev_rule(folder)
    if rule is not None:
        yield good(f"the udev rule {rule} lets users open USB3 Vision cameras")
    elif os.name == "posix" and folder.parent.is_dir():
        yield note("no udev rule lets users open USB3 Vision cameras", sudo_command("setup", "udev"))


def transfer_memory(place: Path) -> Iterator[Finding]:
    """Check the kernel's limit for transfers in flight, 16 MB by default."""
    try:
        limit = int(place.read_text())
    except (OSError, ValueError):
        return
    if 0 < limit < WANTED_USBFS_MB:
        yield note(
            f"the kernel grants {limit} MB to USB transfers of all programs; large frames need more",
            f"echo {WANTED_USBFS_MB} | sudo tee {place}",
        )
    else:
        yield good("the kernel grants enough memory to USB transfers")


def usb_cameras() -> Iterator[Finding]:
    """List the cameras found."""
    from grabbergui.driver.u3v import device

    try:
        found = device.discover(1.0)
    except GrabberError as error:
        yield problem(f"looking for USB3 Vision cameras failed: {error}", "check the cable and the udev rule")
        return
    for info in found:
        if info.note:
            yield problem(f"{info.title} is seen but cannot be used: {info.note}", "see above")
        else:
            yield good(f"{info.title} on USB ({info.address})")
    if not found:
        yield note("no USB3 Vision camera is plugged in")


# -- software ------------------------------------------------------------------------------------
def check_software() -> Iterator[Finding]:
    """The display, YARP and ROS 2."""
    yield from display(os.environ, sys.platform)
    yield from yarp()
    yield from ros2()


def display(environment: Mapping[str, str], platform: str) -> Iterator[Finding]:
    """Check the display for the window."""
    if not platform.startswith("linux") or environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"):
        yield good("there is a display for the window")
    else:
        yield note("there is no display", shell_command("gui", "--offscreen", "--screenshot", "window.png"))


def yarp() -> Iterator[Finding]:
    """Check the name server that YARP's configuration names."""
    from grabbergui.net.yarp.os.name_client import NameClient

    try:
        names = NameClient.find()
        ports = names.list()
    except GrabberError as error:
        yield note(f"no YARP network: {error}", f"{shell_command('yarp-server')} runs a name server")
    else:
        yield good(
            f"the YARP name server at {names.server.host}:{names.server.port} knows {len(ports)} ports"
        )


def ros2() -> Iterator[Finding]:
    """Check whether rclpy can be imported."""
    if importlib.util.find_spec("rclpy") is None:
        yield note(
            "ROS 2 is not installed here",
            f"{shell_command('setup', 'ros2')}, or source the system's setup.bash first",
        )
    else:
        yield good("ROS 2 is installed")


# -- memory of ROS 2 -----------------------------------------------------------------------------
def shared_memory(folder: Path) -> Iterator[Finding]:
    """Report the memory that killed programs left behind, and files of others in the way of ROS 2."""
    from grabbergui.net.ros2 import shared_memory as ros2_memory

    found = ros2_memory.leftovers(folder)
    if found:
        yield note(
            f"killed ROS 2 programs left {ros2_memory.megabytes(found)} in {folder}: {len(found)} segments "
            "and ports of Fast DDS that no process uses",
            shell_command("doctor", "--clear-shared-memory"),
        )
    elif folder.is_dir():
        yield good(f"no killed ROS 2 program left shared memory in {folder}")
    try:
        ros2_memory.require_unblocked(folder)
    except GrabberError as error:
        yield problem(str(error), "find out who put it there")
    if why := ros2_memory.irregular(folder):
        yield problem(f"ROS 2 programs hang here, or send by UDP: {why}", "find out who put it there")
