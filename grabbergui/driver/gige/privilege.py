"""The control privilege of a GigE Vision camera: taking, offering and releasing it, and its holder.

One application at a time controls a camera: the one that wrote the privilege to CCP, until it releases
control or is silent for the heartbeat timeout (GigE Vision 2.2, "Control Channel Privilege").
"""

from __future__ import annotations

import errno
import itertools
import logging
import os
import socket
import time
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import psutil

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceStatusError,
    GrabberError,
    ProtocolError,
)
from grabbergui.driver.gige.bootstrap import (
    PORT_MASK,
    BootstrapRegister,
    ControlPrivilege,
    GvcpCapability,
    ip_text,
)
from grabbergui.driver.gige.control_channel import ControlTiming
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.gvcp import Status, WriteReg
from grabbergui.driver.gige.heartbeat import PRIVILEGE_AND_HOLDER, Holder

log = logging.getLogger(__name__)

SWITCHOVER_KEY = 0x4742
"""The camera hands control over to programs that request it with this key: ours, if their user wants it. It
refuses others, so no program loses control by accident."""
BRIEF = ControlTiming(ack_timeout=0.2, tries=2)
"Timing of commands that a camera may leave unanswered: taking control from another program, releasing it."
HELD = ControlPrivilege.CONTROL | ControlPrivilege.EXCLUSIVE
LONGEST_WAIT = 5.0
"Longest wait in seconds for a camera to release an ended controller. The usual heartbeat timeout is 3 s."
KEEP_CONTROLLER = 20.0
"Seconds for which the name of a program in control is kept."
LOOK_AGAIN = 0.05
"Seconds between two checks whether control is free."


def take(link: ControlLink, camera: str, capability: GvcpCapability, *, take_over: bool = False) -> None:
    """Take control of a camera, with `take_over` also from an application that offers it.

    If the controller was a program on this machine that was killed, wait for its heartbeat timeout. `camera`
    is the camera's name in messages. Raises AccessDeniedError, which names the controller; else as
    `ControlLink.execute`.
    """
    if _granted(link, camera, capability, take_over=take_over):
        return
    holder = _controller(link)
    if holder is not None and holder.ended and _released_in_time(link):
        if _granted(link, camera, capability, take_over=take_over):
            return
        holder = _controller(link)
    if holder is not None and holder.process == os.getpid():
        raise AccessDeniedError(f"this program controls {camera} already; close it first")
    where = f" at {holder}" if holder is not None else ""
    instead = f", or open {' or '.join(holder.served)}" if holder is not None and holder.served else ""
    raise AccessDeniedError(f"another application{where} controls {camera}; close it there{instead}")


def _granted(link: ControlLink, camera: str, capability: GvcpCapability, *, take_over: bool) -> bool:
    held = bool(link.read_register(BootstrapRegister.CCP) & HELD)
    privilege: int = ControlPrivilege.CONTROL
    if held and take_over and capability & GvcpCapability.SWITCHOVER:
        privilege |= SWITCHOVER_KEY << 16
    try:
        # Some devices do not answer a refused write, so retry only briefly if another program has control.
        link.execute(WriteReg(((BootstrapRegister.CCP, privilege),)), BRIEF if held else None)
    except DeviceStatusError as error:
        if error.status == Status.ACCESS_DENIED:
            return False
        raise
    except AckTimeoutError as error:
        if error.postponed:  # by whoever answers as the camera; nobody refused
            link.send_last(WriteReg(((BootstrapRegister.CCP, 0),)))
            raise
        # Release, in case only the answer was lost; a device ignores this from all but the holder.
        release(link, camera)
        link.read_register(BootstrapRegister.CCP)
        return False
    return True


def _released_in_time(link: ControlLink) -> bool:
    """Wait until the camera has released its ended controller; return whether it did in time."""
    timeout = link.read_register(BootstrapRegister.HEARTBEAT_TIMEOUT_MS) / 1000
    end = time.monotonic() + min(1.2 * timeout, LONGEST_WAIT)
    while link.read_register(BootstrapRegister.CCP) & HELD:
        if time.monotonic() >= end:
            return False
        time.sleep(LOOK_AGAIN)
    return True


def offer(link: ControlLink, camera: str, capability: GvcpCapability) -> None:
    """Offer control to other instances of this program, if the camera can hand it over."""
    if not capability & GvcpCapability.SWITCHOVER:
        return
    try:
        link.execute(WriteReg(((BootstrapRegister.CONTROL_SWITCHOVER_KEY, SWITCHOVER_KEY),)))
        link.execute(
            WriteReg(((BootstrapRegister.CCP, ControlPrivilege.CONTROL | ControlPrivilege.SWITCHOVER),))
        )
    except DeviceStatusError as error:
        log.info("%s: control cannot be offered to others: %s", camera, error)


def release(link: ControlLink, camera: str) -> None:
    """Release control; otherwise the camera refuses all others until the heartbeat timeout."""
    free = WriteReg(((BootstrapRegister.CCP, 0),))
    if link.lost is not None or link.abandoned:
        link.send_last(free)
        return
    try:
        link.execute(free, BRIEF)
    except GrabberError as error:
        log.info("releasing %s: %s", camera, error)


def holder_of(link: ControlLink, capability: GvcpCapability) -> Holder | None:
    """Read the holder right after we took control: behind a router it is not our own address."""
    needed = GvcpCapability.PRIMARY_APPLICATION | GvcpCapability.CONCATENATION
    if capability & needed != needed:
        return None
    try:
        _, *holder = PRIVILEGE_AND_HOLDER.decode_ack(link.execute(PRIVILEGE_AND_HOLDER))
    except (DeviceStatusError, ProtocolError) as error:
        log.info("the holder of control cannot be read: %s", error)
        return None
    return holder[0], holder[1]


class _Controller(NamedTuple):
    """The application that controls a camera, as far as this machine knows."""

    address: str
    ended: bool = False
    "Whether it ran on this machine and its socket is closed."
    process: int | None = None
    name: str = ""
    served: tuple[str, ...] = ()
    "The URIs at which it shares the camera, if it is a server of ours."

    def __str__(self) -> str:
        return f"{self.address} ({self.name}, PID {self.process})" if self.process else self.address


def user_of(link: ControlLink) -> str:
    """Return who controls a camera, read without taking control; empty if nobody does, or this program.

    Raises AckTimeoutError, TransportError, ProtocolError.
    """
    try:
        if not link.read_register(BootstrapRegister.CCP) & HELD:
            return ""
    except DeviceStatusError:
        return "another program"  # with exclusive access
    place = _controller_place(link)
    if place is None:
        return "another program"
    # To look through the processes of this machine is too costly for every search.
    holder = _kept_controller(*place, int(time.monotonic() // KEEP_CONTROLLER))
    if holder.process == os.getpid():
        return ""
    return f"{holder.name}, PID {holder.process}" if holder.process else f"a program at {holder.address}"


def _controller(link: ControlLink) -> _Controller | None:
    """Return the application in control; None if the camera does not report it."""
    place = _controller_place(link)
    return _controller_at(*place) if place is not None else None


def _controller_place(link: ControlLink) -> tuple[str, int] | None:
    """Return address and port of the application in control; None if the camera does not report them."""
    try:
        number = link.read_register(BootstrapRegister.PRIMARY_APPLICATION_IP)
        port = link.read_register(BootstrapRegister.PRIMARY_APPLICATION_PORT) & PORT_MASK
    except GrabberError:
        return None  # only a detail of a message
    return (ip_text(number), port) if number else None


@lru_cache(maxsize=64)
def _kept_controller(address: str, port: int, period: int) -> _Controller:
    """Return the same application for the whole `period`, a number."""
    return _controller_at(address, port)


def _controller_at(address: str, port: int) -> _Controller:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((address, port))
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                return _local_controller(address, port)
            return _Controller(address)  # on another machine
    return _Controller(address, ended=port != 0)


def served_uris(command: Sequence[str]) -> Iterator[str]:
    """Yield the URIs at which a command line of ours shares its camera: `serve … --yarp /grabber`.

    `rig serve` shares each camera below that name, by its own in the rig.
    """
    if "serve" not in command:
        return
    below = "/CAMERA" if "rig" in command else ""
    words = [part for word in command for part in word.split("=", 1)]
    for option, value in itertools.pairwise(words):
        if option in ("--yarp", "--ros2"):
            yield f"{option.removeprefix('--')}:/{value.strip('/')}{below}"


def _local_controller(address: str, port: int) -> _Controller:
    try:
        for connection in psutil.net_connections("udp4"):
            if connection.pid and connection.laddr in ((address, port), ("0.0.0.0", port)):
                process = psutil.Process(connection.pid)
                served = tuple(served_uris(process.cmdline()))
                return _Controller(address, process=process.pid, name=process.name(), served=served)
    except (psutil.Error, OSError) as error:
        log.debug("the process at %s:%d cannot be named: %s", address, port, error)
    return _Controller(address)
