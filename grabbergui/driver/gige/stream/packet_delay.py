"""The pause between stream packets: what the user wants, and the camera accepts."""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass

from grabbergui.core.errors import UsageError
from grabbergui.driver.gige.bootstrap import BootstrapRegister, GvcpCapability, StreamChannel
from grabbergui.driver.gige.device_memory import DeviceMemory

log = logging.getLogger(__name__)

ETHERNET_BYTES = 38
"Preamble, header, checksum and gap around each IP datagram on the wire."
USUAL_LINK = 1_000_000_000 / 8
"Bytes per second, if the camera does not report its link's speed."
SLOWEST = 10_000.0
"Bytes per second below which no frame would ever arrive."
LONGEST = 0.1
"Seconds between two packets."

_DURATION = re.compile(r"(\d+(?:\.\d+)?)(ns|us|µs|ms)", re.IGNORECASE)
_RATE = re.compile(r"(\d+(?:\.\d+)?)(k|M|G)?B(?:/s|ps)?")
_UNITS = {"ns": 1e-9, "us": 1e-6, "µs": 1e-6, "ms": 1e-3}
_FACTORS = {None: 1.0, "k": 1e3, "M": 1e6, "G": 1e9}


@dataclass(frozen=True)
class PacketDelayPolicy:
    """A pause between packets, or a bandwidth that pauses limit; neither: the camera's own setting."""

    seconds: float | None = None
    bytes_per_second: float | None = None
    "Rate of IP datagrams, headers included."

    @classmethod
    def parse(cls, delay: str, bandwidth: str) -> PacketDelayPolicy:
        """Parse a URI's `packet_delay` and `bandwidth`. Raises UsageError."""
        if delay and bandwidth:
            raise UsageError("packet_delay and bandwidth exclude each other: write one of them")
        if bandwidth:
            match = _RATE.fullmatch(bandwidth)
            rate = float(match[1]) * _FACTORS[match[2]] if match else 0.0
            if rate < SLOWEST:
                raise UsageError(f"bandwidth={bandwidth}: write e.g. 60MB, from {SLOWEST / 1000:g}kB on")
            return cls(bytes_per_second=rate)
        if delay:
            match = _DURATION.fullmatch(delay)
            seconds = float(match[1]) * _UNITS[match[2].lower()] if match else 0.0 if delay == "0" else -1.0
            if not 0 <= seconds <= LONGEST:
                raise UsageError(f"packet_delay={delay}: write e.g. 10us, at most {LONGEST * 1000:g}ms")
            return cls(seconds=seconds)
        return cls()

    def pause(self, packet_size: int, link: float) -> float | None:
        """Return the seconds from the end of a packet to the next; None: leave the camera's setting.

        `packet_size` in bytes of an IP datagram, `link` in bytes per second on the wire.
        """
        if self.bytes_per_second is None:
            return self.seconds
        return max(packet_size / self.bytes_per_second - (packet_size + ETHERNET_BYTES) / link, 0.0)


def settle_delay(
    memory: DeviceMemory, channel: StreamChannel, policy: PacketDelayPolicy, packet_size: int, frequency: int
) -> None:
    """Write the pause that is wanted, if one is, in ticks of the camera's clock (`frequency` Hz).

    Raises as register reads and writes do.
    """
    link = USUAL_LINK if policy.bytes_per_second is None else _link_of(memory)
    pause = policy.pause(packet_size, link)
    if pause is None:
        return
    if not frequency:
        log.warning("this camera has no clock, so its packet delay cannot be set")
        return
    ticks = round(pause * frequency)
    if not memory.write_optional(channel.packet_delay, ticks):
        log.warning("the camera does not take a packet delay; its own stays")
        return
    held = memory.read_optional(channel.packet_delay, ticks)
    if abs(held - ticks) > max(1, ticks // 10):
        log.warning("packet delay of %d ticks was requested, the camera uses %d", ticks, held)


def _link_of(memory: DeviceMemory) -> float:
    if not memory.capability & GvcpCapability.LINK_SPEED:
        return USUAL_LINK
    megabits = memory.read_optional(BootstrapRegister.LINK_SPEED)
    return megabits * 1e6 / 8 if megabits else USUAL_LINK
