"""Checks for the usual problems between a camera and the window: findings, each with its remedy.

GigE Vision: kernel settings, interfaces, cameras that cannot be reached. USB3 Vision: permissions and memory
of the kernel for transfers. Software: the display of the window, YARP, ROS 2 and what it left in memory.

The drivers are imported by the checks that need them: the window knows findings from its start on.
"""

from __future__ import annotations

import importlib.util
import os
import re
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from enum import Enum
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from grabbergui.core.environment import shell_command, sudo_command
from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.core.scheduling import REALTIME, realtime_threads_permitted
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
    yield from shared_memory(SHARED_MEMORY)


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
    for one, other in combinations(found, 2):
        if one.name != other.name and one.network.overlaps(other.network):
            yield problem(
                f"{one.name} ({one.ip}) and {other.name} ({other.ip}) are in one subnet, {one.network}; "
                "the system may use the wrong one for a camera",
                f"give {other.name} and its cameras addresses of another subnet",
            )


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


# -- memory that ROS 2 left ----------------------------------------------------------------------
SHARED_MEMORY = Path("/dev/shm")
_YOUNGEST = 10.0
"""Seconds; a younger segment may not be complete and locked yet."""
_FAST_DDS = re.compile(r"(?:sem\.)?(?P<thing>fastdds_(?:[0-9a-f]{16}|port\d+))(?P<part>_el|_sl|_mutex)?")
"""Each of its participants has segments and ports in shared memory.

The owner holds a lock (flock) on a file `…_el` beside it, readers of a shared port one on `…_sl`; the kernel
ends these locks with the process, however that ends.
"""


@dataclass(frozen=True)
class Leftover:
    """A segment or port that no process uses."""

    name: str
    files: tuple[Path, ...]
    "The memory itself, its locks and its semaphore."
    size: int
    "Bytes of memory that it takes."


def shared_memory(folder: Path) -> Iterator[Finding]:
    """Report the memory that killed programs left behind."""
    found = leftovers(folder)
    if found:
        yield note(
            f"killed ROS 2 programs left {megabytes(found)} in {folder}: {len(found)} segments and ports "
            "of Fast DDS that no process uses",
            shell_command("doctor", "--clear-shared-memory"),
        )
    elif folder.is_dir():
        yield good(f"no killed ROS 2 program left shared memory in {folder}")


def leftovers(folder: Path, *, youngest: float = _YOUNGEST) -> list[Leftover]:
    """Return segments that no process uses and this user may remove, by name. `youngest` is in seconds."""
    if sys.platform == "win32":
        return []
    things: dict[str, list[Path]] = {}
    mapped = _mapped()
    with suppress(FileNotFoundError):
        for path in sorted(folder.iterdir()):
            if match := _FAST_DDS.fullmatch(path.name):
                things.setdefault(match["thing"], []).append(path)
    found = []
    for name, files in things.items():
        with ExitStack() as stack, suppress(FileNotFoundError):  # its owner may remove it meanwhile
            states = [path.stat() for path in files]
            ours = os.geteuid() in (0, *(state.st_uid for state in states))
            idle = time.time() - max(state.st_mtime for state in states) >= youngest
            if ours and idle and mapped.isdisjoint(map(_identity, states)) and _lock(files, stack):
                found.append(Leftover(name, tuple(files), sum(state.st_blocks * 512 for state in states)))
    return found


def clear(found: Sequence[Leftover]) -> list[Leftover]:
    """Remove the segments that still have no owner; return those removed. Raises AccessDeniedError."""
    mapped = _mapped()
    removed = []
    for leftover in found:
        with ExitStack() as stack, suppress(FileNotFoundError):
            # The locks are held until all is gone, so that no starting program takes it over half removed.
            states = [path.stat() for path in leftover.files]
            if mapped.isdisjoint(map(_identity, states)) and _lock(leftover.files, stack):
                _remove(leftover)
                removed.append(leftover)
    return removed


def megabytes(found: Sequence[Leftover]) -> str:
    """Return the bytes of all leftovers."""
    return f"{sum(leftover.size for leftover in found) / 1e6:.1f} MB"


def _remove(leftover: Leftover) -> None:
    # Locks last: as long as they are there and held, nobody else thinks the name free.
    for path in sorted(leftover.files, key=lambda path: path.name.endswith(("_el", "_sl"))):
        try:
            path.unlink(missing_ok=True)
        except PermissionError as error:
            raise AccessDeniedError(
                f"{path} cannot be removed by this user; run: "
                + sudo_command("doctor", "--clear-shared-memory")
            ) from error


def _lock(files: Sequence[Path], stack: ExitStack) -> bool:
    """Take all locks for as long as `stack` is open; false if a process, in any container, holds one."""
    if sys.platform == "win32":
        return False
    import fcntl

    for path in files:
        if not path.name.endswith(("_el", "_sl")):
            continue
        try:
            file = stack.enter_context(path.open("rb"))
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            return False
    return True


def _mapped() -> frozenset[tuple[int, int]]:
    """Return device and inode of every file mapped by a process that we may inspect.

    A port is used by those who send to it too, and these hold no lock.
    """
    found: set[tuple[int, int]] = set()
    if sys.platform == "win32":
        return frozenset(found)
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with suppress(OSError):  # another user's, or it has ended
            for line in maps.read_text(errors="replace").splitlines():
                _, _, _, device, inode, *path = line.split(maxsplit=5)
                if path and "fastdds_" in path[0]:
                    major, minor = (int(part, 16) for part in device.split(":"))
                    found.add((os.makedev(major, minor), int(inode)))
    return frozenset(found)


def _identity(state: os.stat_result) -> tuple[int, int]:
    return state.st_dev, state.st_ino
