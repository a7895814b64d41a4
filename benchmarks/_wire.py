"""A wire between two network namespaces that behaves as one with a network card at its end. Linux, root.

Its receiving end polls in a thread of the kernel, as a card with moderated interrupts does, so that the
kernel joins packets; its sending end cuts large sends, so that each packet travels singly. What the kernel
does with arriving packets takes that thread's time, and not the sender's as on the loopback.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

CAMERA, HOST = "10.77.0.2", "10.77.0.1"
"Addresses of the two ends."
FLUSH_NS = 50_000
"How long the receiving end gathers packets, as a card's moderated interrupts do."
_NEW_NETWORK = 0x40000000
"Linux's CLONE_NEWNET."


class NoWireError(SystemExit):
    """This system cannot make such a wire, or may not."""


@contextmanager
def wire() -> Iterator[tuple[str, str]]:
    """Make the two namespaces; yield the camera's and the host's name. Removed afterwards.

    Raises NoWireError.
    """
    camera, host = f"camera{os.getpid()}", f"host{os.getpid()}"
    with ExitStack() as stack:
        for name in (camera, host):
            _run("ip", "netns", "add", name)
            stack.callback(_run, "ip", "netns", "del", name)
        device = _device()
        ends = [device, "netns", host, "type", "veth", "peer", "name", device, "netns", camera]
        _run("ip", "link", "add", *ends)
        for name, address in ((camera, CAMERA), (host, HOST)):
            _run("ip", "-n", name, "addr", "add", f"{address}/24", "dev", device)
            _run("ip", "-n", name, "link", "set", "lo", "up")
            _run("ip", "-n", name, "link", "set", device, "mtu", "9000", "up")
        singly = ("tso", "gso", "tx-udp-segmentation")
        _run(*inside(camera), "ethtool", "-K", device, *(word for name in singly for word in (name, "off")))
        _run(*inside(host), "ethtool", "-K", device, "gro", "on")
        settings = {"threaded": 1, "gro_flush_timeout": FLUSH_NS, "napi_defer_hard_irqs": 2}
        for setting, value in settings.items():
            _run(*inside(host), "sh", "-c", f"echo {value} > /sys/class/net/{device}/{setting}")
        yield camera, host


def inside(namespace: str) -> list[str]:
    """Return the words before a command that is to run in a namespace."""
    return ["ip", "netns", "exec", namespace]


@contextmanager
def moved_into(namespace: str) -> Iterator[None]:
    """Let this thread, and the processes that it starts, use a namespace's network."""
    enter = ctypes.CDLL(None, use_errno=True).setns
    with Path("/proc/thread-self/ns/net").open() as before, Path("/run/netns", namespace).open() as there:
        if enter(there.fileno(), _NEW_NETWORK):
            raise OSError(ctypes.get_errno(), f"cannot enter the network of {namespace}")
        try:
            yield
        finally:
            enter(before.fileno(), _NEW_NETWORK)


def network_seconds(maker: int | None = None) -> float:
    """Return the CPU seconds of the kernel's threads that poll the wire of a process, by default this one."""
    used = 0.0
    for process in Path("/proc").iterdir():
        if process.name.isdigit():
            with suppress(OSError):
                if (process / "comm").read_text().startswith(f"napi/{_device(maker)}-"):
                    used += process_seconds(int(process.name))
    return used


def process_seconds(process_id: int) -> float:
    """Return the CPU seconds of a process with all its threads. Raises OSError if it has ended."""
    return time.clock_gettime((~process_id << 3) | 2)  # Linux's clock id: CPUCLOCK_SCHED of a process


def _device(maker: int | None = None) -> str:
    """Return the name of both ends, which the kernel's threads have in theirs (15 letters)."""
    return f"e{maker or os.getpid()}"


def _run(*command: str) -> None:
    try:
        subprocess.run(command, check=True, capture_output=True, text=True)
    except FileNotFoundError as error:
        raise NoWireError(f"{command[0]} is not installed") from error
    except subprocess.CalledProcessError as error:
        raise NoWireError(
            f"no network namespaces here: {' '.join(command)}: {error.stderr.strip()}"
        ) from error
