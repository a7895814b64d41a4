"""The pause between stream packets, by which several cameras share a link, or one spares a slow host."""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass

from grabbergui.core.errors import UsageError
from grabbergui.driver.gige.bootstrap import Capability, Register, StreamChannel
from grabbergui.driver.gige.memory import DeviceMemory

log = logging.getLogger(__name__)

ETHERNET_BYTES = 38
"Preamble, header, checksum and gap around each IP datagram on the wire."
USUAL_LINK = 1_000_000_000 / 8
"Bytes per second, where the camera does not tell its link's speed."
SLOWEST = 10_000.0
"Bytes per second below which no picture would ever arrive."
LONGEST = 0.1
"Seconds between two packets."

_DURATION = re.compile(r"(\d+(?:\.\d+)?)(ns|us|µs|ms)", re.IGNORECASE)
_RATE = re.compile(r"(\d+(?:\.\d+)?)(k|M|G)?B(?:/s|ps)?")
_UNITS = {"ns": 1e-9, "us": 1e-6, "µs": 1e-6, "ms": 1e-3}
_FACTORS = {None: 1.0, "k": 1e3, "M": 1e6, "G": 1e9}


@dataclass(frozen=True)
class PacketDelayPolicy:
    """A pause, or the bandwidth that pauses shall leave; neither: what the camera holds."""

    seconds: float | None = None
    bytes_per_second: float | None = None
    "Of IP datagrams, headers included."

    @classmethod
    def parse(cls, delay: str, bandwidth: str) -> PacketDelayPolicy:
        """Of a URI's `packet_delay` and `bandwidth`. Raises UsageError."""
        if delay and bandwidth:
            raise UsageError("packet_delay and bandwidth say the same thing: write one of them")
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
        """Seconds between the end of one packet and the begin of the next; None: leave it as it is.

        `packet_size` in bytes of an IP datagram, `link` in bytes per second on the wire.
        """
        if self.bytes_per_second is None:
            return self.seconds
        return max(packet_size / self.bytes_per_second - (packet_size + ETHERNET_BYTES) / link, 0.0)


def settle_delay(
    memory: DeviceMemory, channel: StreamChannel, policy: PacketDelayPolicy, packet_size: int, frequency: int
) -> int:
    """Write the pause in ticks of the camera's clock (`frequency` Hz); the ticks that it holds.

    Raises as register reads and writes do.
    """
    pause = policy.pause(packet_size, _link_of(memory))
    if pause is None:
        return memory.read_register(channel.packet_delay)
    if not frequency:
        log.warning("this camera has no clock by which its packet delay could be told")
        return 0
    ticks = round(pause * frequency)
    memory.write_register(channel.packet_delay, ticks)
    held = memory.read_register(channel.packet_delay)
    if abs(held - ticks) > max(1, ticks // 10):
        log.warning("packet delay of %d ticks was asked for, the camera holds %d", ticks, held)
    return held


def _link_of(memory: DeviceMemory) -> float:
    if not memory.capability & Capability.LINK_SPEED:
        return USUAL_LINK
    megabits = memory.read_register(Register.LINK_SPEED)
    return megabits * 1e6 / 8 if megabits else USUAL_LINK
