"""A GenTL producer's own module of a camera, and how it accesses the camera's registers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from genicam import genapi

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.description import fetch_description
from grabbergui.driver.genapi.cleaning import clean_xml, port_name
from grabbergui.driver.genapi.loading import load
from grabbergui.driver.genapi.port import RegisterPort
from grabbergui.driver.gentl.errors import answering

ORDER_MECHANISM = "DeviceEndianessMechanism"
"""Feature of the local device module; `Legacy`: registers of four bytes are accessed as numbers."""
WRITABLE = (genapi.EAccessMode.WO, genapi.EAccessMode.RW)


@dataclass
class _LocalRegisters:
    """The registers of a module of the producer itself."""

    port: Any

    def read(self, address: int, length: int) -> bytes:
        return bytes(self.port.read(address, length)[1])

    def write(self, address: int, data: bytes) -> None:
        self.port.write(address, data)


def choose_order_mechanism(device: Any, *, numbers: bool) -> None:
    """Tell the producer of an open GigE Vision camera how to access registers of four bytes.

    GenICam standard 2.1.1, 3.1.3. A producer decides by itself without the feature, or where it only
    shows it, as Baumer's does. Raises GrabberError if the producer's own description cannot be used.
    """
    with answering("reading the producer's description of its device module"):
        registers = _LocalRegisters(device.local_port)
        urls = [info.url for info in registers.port.url_info_list]
        text = clean_xml(fetch_description(urls, registers.read))
        if ORDER_MECHANISM not in text:
            return
        nodes, port = load(text), RegisterPort(registers)
        nodes.connect(port, port_name(text))
        try:
            mechanism = nodes.get_node(ORDER_MECHANISM)
            if mechanism.get_access_mode() in WRITABLE:
                mechanism.value = "Legacy" if numbers else "Standard"
        except genapi.GenericException as error:
            raise RemoteProtocolError(f"the producer's {ORDER_MECHANISM} cannot be set: {error}") from error
        finally:
            nodes.disconnect()
