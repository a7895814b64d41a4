"""Tests which packet sizes get from a camera to this host, for reports."""

from __future__ import annotations

import socket
from contextlib import suppress

from grabbergui.core.errors import GrabberError
from grabbergui.driver.gige.bootstrap import StreamChannel, ip_number
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.gige.interfaces import Interface
from grabbergui.driver.gige.stream.packet_size import SMALLEST, STEP, USUAL_SIZES, PacketSizer


def arriving_sizes(
    memory: DeviceMemory, interface: Interface, device_ip: str, channel: StreamChannel
) -> list[tuple[int, bool]]:
    """Return each size in bytes of an IP datagram, the largest first, and whether a test packet arrived.

    Needs control, and a closed stream channel, whose registers are afterwards as before. Raises as register
    reads and writes do.
    """
    registers = (channel.packet_size, channel.destination, channel.port)
    before = [(register, memory.read_register(register)) for register in registers]
    sizes = {size - size % STEP for size in (*USUAL_SIZES, min(interface.mtu, 0xFFFF)) if size >= SMALLEST}
    sizer = PacketSizer(channel, memory, interface)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind((interface.ip, 0))
        try:
            memory.write_register(channel.destination, ip_number(interface.ip))
            memory.write_register(channel.port, receiver.getsockname()[1])
            return [(size, sizer.arrives(size, receiver, device_ip)) for size in sorted(sizes, reverse=True)]
        finally:
            for register, value in before:
                with suppress(GrabberError):
                    memory.write_register(register, value)
