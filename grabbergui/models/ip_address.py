"""Giving a GigE Vision camera an IP address: until power-off, or for good.

The driver is imported when it is needed, on the thread that talks to the camera.
"""

from __future__ import annotations

import ipaddress
import logging
import threading
import time
from contextlib import closing, suppress

from psygnal import Signal

from grabbergui.core.errors import GrabberError, SourceNotFoundError, TransportError
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.error_text import error_text
from grabbergui.models.language import translate

log = logging.getLogger(__name__)

GIGE = "GigE Vision"
"The bus of cameras that have an address."
RETURN_SECONDS = 5.0
"Longest wait for a camera at its new address."
_FALLBACK = ("", "255.255.255.0")


def has_address(info: DeviceInfo) -> bool:
    """Return whether a listed source is a camera that can be given an address."""
    return info.bus == GIGE and bool(info.hardware_id)


class IpAddressModel:
    """Sets the address of one camera on a thread of its own. Signals are emitted there."""

    done = Signal(str)
    """The address was set; a sentence as display text."""
    failed = Signal(str)
    """Why it was not, as display text."""

    def __init__(self, info: DeviceInfo) -> None:
        self.info = info
        self._thread: threading.Thread | None = None

    def proposal(self) -> tuple[str, str]:
        """Return an address in the subnet of the interface on which the camera was seen, and its mask.

        Its present address if it is in that subnet; else one with the same last number, if that is free here.
        """
        from grabbergui.driver.gige.interfaces import interfaces

        found = next((one for one in interfaces() if one.name == self.info.interface), None)
        if found is None:
            return self.info.address, _FALLBACK[1]
        network = ipaddress.IPv4Network(f"{found.ip}/{found.netmask}", strict=False)
        with suppress(ValueError):
            present = ipaddress.IPv4Address(self.info.address)
            if present in network:
                return self.info.address, found.netmask
            proposed = network.network_address + int(present) % network.num_addresses
            taken = (network.network_address, network.broadcast_address, ipaddress.IPv4Address(found.ip))
            while proposed in taken:
                proposed = network.network_address + (int(proposed) + 1) % network.num_addresses
            return str(proposed), found.netmask
        return _FALLBACK

    def set(self, ip: str, mask: str, gateway: str, *, keep: bool) -> None:
        """Give the camera an address; `keep` it after power-off. Never waits; does nothing while it works."""
        if self._thread is not None and self._thread.is_alive():
            return

        def work() -> None:
            try:
                self._set(ip, mask, gateway or "0.0.0.0", keep)
            except GrabberError as error:
                self.failed.emit(error_text(error))

        self._thread = threading.Thread(target=work, name="IP address", daemon=True)
        self._thread.start()

    def wait(self, timeout: float) -> bool:
        """Return whether it has finished within `timeout` seconds."""
        if self._thread is not None:
            self._thread.join(timeout)
        return self._thread is None or not self._thread.is_alive()

    def _set(self, ip: str, mask: str, gateway: str, keep: bool) -> None:
        from grabbergui.driver.gige import address_commands
        from grabbergui.driver.gige.identity import ForceIp

        address_commands.check_addresses(ip, mask, gateway)
        if ip != self.info.address:
            address_commands.force_ip(ForceIp(self.info.hardware_id, ip, mask, gateway))
        if keep:
            self._keep(ip, mask, gateway)
            text = translate("IpAddress", "The camera has the address {0}, also after its next start.")
        else:
            text = translate("IpAddress", "The camera has the address {0} until it is switched off.")
        self.done.emit(text.format(ip))

    def _keep(self, ip: str, mask: str, gateway: str) -> None:
        """Write the persistent address once the camera answers at the new one."""
        from grabbergui.driver.gige import address_commands
        from grabbergui.driver.gige.device import GigeDevice

        deadline = time.monotonic() + RETURN_SECONDS
        while True:
            device = GigeDevice(ip)
            try:
                with closing(device):
                    device.open(Access.CONTROL)
                    address_commands.keep_address(device, ip, mask, gateway)
                    return
            except (TransportError, SourceNotFoundError) as error:
                if time.monotonic() >= deadline:
                    raise
                log.debug("%s does not answer yet: %s", ip, error)
