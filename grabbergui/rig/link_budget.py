"""Shares of one link for several cameras, and how each is kept to its share. No I/O.

Cameras that are triggered together send together: six at the full rate of their own cables fill the switch's
buffer within a millisecond, although they need little of the link on average. The budget gives each camera a
share of the link in proportion to what it needs and spreads its packets over time:

- by a pause after each packet (GevSCPD), the best way, because all cameras then send evenly;
- or by a limit that the camera keeps itself (DeviceLinkThroughputLimit);
- or by turns: a camera that can only delay whole frames (GevSCFTD) sends its frame after the one before.

Sizes are bytes, rates bytes per second, durations seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

GVSP_HEADERS = 36
"Bytes of IP, UDP and GVSP headers in a packet of the size that GevSCPSPacketSize gives."
ETHERNET = 38
"Bytes of preamble, header, checksum and gap around each packet on the wire."
LEADER_TRAILER = 2 * 84
"Bytes of a frame's leader and trailer on the wire."
SPARE = 1.02
"Frames are sent by this much faster than the share requires, as clocks and frame rates are not exact."


class Pacing(Enum):
    """How a camera is kept to its share."""

    PACKET_DELAY = "GevSCPD"
    THROUGHPUT_LIMIT = "DeviceLinkThroughputLimit"
    FRAME_DELAY = "GevSCFTD"
    NONE = "-"


@dataclass(frozen=True)
class CameraLoad:
    """A camera's needs, and its means to keep to a share."""

    name: str
    payload: int
    "Bytes of a frame."
    frame_rate: float
    "Hz."
    packet_size: int = 1500
    "Bytes of an IP packet; 0 for a camera without packets (USB3 Vision)."
    link: float = 125e6
    "Rate of the camera's own cable."
    tick_frequency: int = 1_000_000_000
    "Frequency in Hz of the ticks in which the packet delay is given."
    means: tuple[Pacing, ...] = (Pacing.PACKET_DELAY,)

    @property
    def packets(self) -> int:
        """Payload packets of a frame."""
        return math.ceil(self.payload / (self.packet_size - GVSP_HEADERS)) if self.packet_size else 1

    @property
    def frame_on_wire(self) -> float:
        """Bytes of a frame on the wire, with all headers."""
        if not self.packet_size:
            return float(self.payload)
        return self.payload + self.packets * (GVSP_HEADERS + ETHERNET) + LEADER_TRAILER

    @property
    def need(self) -> float:
        """Bytes per second on the wire."""
        return self.frame_on_wire * self.frame_rate


@dataclass(frozen=True)
class SharedLink:
    """The link that all cameras share: the cable to this computer, and the switch before it."""

    rate: float = 125e6
    share: float = 0.9
    "Part of the rate that may be used."
    buffer: float = 128e3
    "Bytes that wait in the switch before packets are dropped."

    @property
    def usable(self) -> float:
        """Bytes per second that may be used."""
        return self.rate * self.share


@dataclass(frozen=True)
class Allotment:
    """A camera's share of the link."""

    load: CameraLoad
    share: float
    "Bytes per second on the wire."
    pacing: Pacing
    settings: dict[str, int] = field(default_factory=dict)
    "Values by feature; delays in ticks."
    frame_time: float = 0.0
    "Seconds from the first packet of a frame to the last."


@dataclass(frozen=True)
class LinkBudget:
    """The shares of all cameras, and whether they fit."""

    link: SharedLink
    allotments: tuple[Allotment, ...]
    problems: tuple[str, ...] = ()

    @property
    def fits(self) -> bool:
        """Whether all frames get through."""
        return not self.problems

    @property
    def names(self) -> tuple[str, ...]:
        """The cameras that share the link."""
        return tuple(each.load.name for each in self.allotments)

    @property
    def need(self) -> float:
        """Bytes per second that all cameras need."""
        return sum(each.load.need for each in self.allotments)

    def table(self) -> list[list[str]]:
        """Return rows for display: a header, a camera each, and the sum."""
        rows = [["camera", "frame", "rate", "packet", "needs", "share", "frame takes", "set"]]
        for each in self.allotments:
            load = each.load
            settings = ", ".join(f"{name}={value}" for name, value in each.settings.items())
            rows.append(
                [
                    load.name,
                    f"{load.payload / 1e6:.2f} MB",
                    f"{load.frame_rate:.4g} Hz",
                    f"{load.packet_size} B" if load.packet_size else "-",
                    f"{load.need / 1e6:.1f} MB/s",
                    f"{each.share / 1e6:.1f} MB/s",
                    f"{each.frame_time * 1000:.1f} ms",
                    settings or "nothing",
                ]
            )
        used = self.need / self.link.rate if self.link.rate else math.inf
        rows.append(
            [
                "all",
                "",
                "",
                "",
                f"{self.need / 1e6:.1f} MB/s",
                f"{self.link.usable / 1e6:.1f} MB/s",
                "",
                f"{used:.0%} of {self.link.rate / 1e6:.1f} MB/s",
            ]
        )
        return rows


def plan(loads: Sequence[CameraLoad], link: SharedLink) -> LinkBudget:
    """Divide the link. All loads get a share in any case; `problems` says why frames would be lost."""
    need = sum(load.need for load in loads)
    problems = []
    if need > link.usable:
        problems.append(
            f"the cameras need {need / 1e6:.1f} MB/s, but {link.share:.0%} of the link are"
            f" {link.usable / 1e6:.1f} MB/s: lower every frame rate to {link.usable / need:.0%} of it, reduce"
            " the images, or use a packed pixel format"
        )
    allotments = []
    waited = 0.0
    for load in loads:
        share = min(link.usable * (load.need / need if need else 1 / len(loads)), load.link)
        allotment = _allot(load, share, waited)
        if allotment.pacing is Pacing.FRAME_DELAY:
            waited += load.frame_on_wire / min(load.link, link.usable)
        if load.need > load.link:
            problems.append(
                f"{load.name} needs {load.need / 1e6:.1f} MB/s, more than its own cable carries"
                f" ({load.link / 1e6:.1f} MB/s)"
            )
        allotments.append(allotment)
    problems += _overflow(allotments, link)
    return LinkBudget(link, tuple(allotments), tuple(problems))


def _allot(load: CameraLoad, share: float, waited: float) -> Allotment:
    """Return how a camera is kept to a share; `waited` is when its turn begins if it sends in turns."""
    if Pacing.PACKET_DELAY in load.means and load.packet_size:
        on_wire = load.packet_size + ETHERNET
        slot = load.frame_on_wire / share / SPARE / load.packets
        pause = max(0.0, slot - on_wire / load.link)
        # Rounded down, as a longer pause might make the frames take longer than their period.
        ticks = math.floor(pause * load.tick_frequency)
        taken = load.packets * (on_wire / load.link + ticks / load.tick_frequency)
        return Allotment(load, share, Pacing.PACKET_DELAY, {"GevSCPD": ticks}, taken)
    if Pacing.THROUGHPUT_LIMIT in load.means:
        limit = math.floor(share * load.payload / load.frame_on_wire)
        settings = {"DeviceLinkThroughputLimit": limit}
        return Allotment(load, share, Pacing.THROUGHPUT_LIMIT, settings, load.payload / limit)
    taken = load.frame_on_wire / load.link
    if Pacing.FRAME_DELAY in load.means:
        ticks = math.ceil(waited * load.tick_frequency)
        return Allotment(load, share, Pacing.FRAME_DELAY, {"GevSCFTD": ticks}, taken)
    return Allotment(load, share, Pacing.NONE, {}, taken)


def _overflow(allotments: Sequence[Allotment], link: SharedLink) -> list[str]:
    """Say if cameras that cannot be paced fill the switch's buffer together."""
    unpaced = [each for each in allotments if each.pacing is Pacing.NONE]
    rate = sum(each.load.link for each in unpaced) + sum(
        each.share for each in allotments if each.pacing is not Pacing.NONE
    )
    longest = max((each.frame_time for each in unpaced), default=0.0)
    waiting = (rate - link.rate) * longest
    if not unpaced or waiting <= link.buffer:
        return []
    names = ", ".join(each.load.name for each in unpaced)
    return [
        f"{names} cannot be paced: {waiting / 1e3:.0f} kB of a frame would wait in the switch, whose buffer"
        f" is {link.buffer / 1e3:.0f} kB; trigger them one after the other"
    ]
