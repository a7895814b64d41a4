"""The node map's door to a device's registers."""

from __future__ import annotations

from genicam import genapi

from grabbergui.core.errors import GrabberError, RemoteProtocolError, TransportError
from grabbergui.driver.device import Device

LONGEST = 16 << 20
"""Bytes of one register: many times the largest look-up table, and what takes a camera seconds."""


class RegisterPort(genapi.AbstractPort):  # type: ignore[misc]  # the library has no types
    """Reads and writes registers of a `Device` for GenApi.

    What the device raises does not survive its way through C++, so it is kept in `failure` for whoever
    made the call; what nobody foresaw becomes a TransportError, since GenApi would end the process.
    """

    def __init__(self, device: Device) -> None:
        super().__init__()
        self._device = device
        self.failure: GrabberError | None = None
        "The last error, until taken by `take_failure`."

    def read(self, address: int, length: int) -> bytes:
        """Called by GenApi."""
        try:
            _require_bearable(address, length)
            return self._device.read(address, length)
        except Exception as error:
            raise self._kept(error) from error

    def write(self, address: int, value: bytes) -> None:
        """Called by GenApi."""
        try:
            _require_bearable(address, len(value))
            self._device.write(address, bytes(value))
        except Exception as error:
            raise self._kept(error) from error

    def get_access_mode(self) -> int:
        """Called by GenApi."""
        return int(genapi.EAccessMode.RW)

    def is_open(self) -> bool:
        """Called by GenApi."""
        return True

    def get_principal_interface_type(self) -> int:
        """Called by GenApi."""
        return int(genapi.EInterfaceType.intfIPort)

    def _kept(self, error: Exception) -> RuntimeError:
        """What GenApi takes; the reason waits for `take_failure`."""
        if not isinstance(error, GrabberError):
            error = TransportError(f"{type(error).__name__}: {error}")
        self.failure = error
        return RuntimeError(str(error))

    def take_failure(self) -> GrabberError | None:
        """The error behind GenApi's last exception, forgotten by this call."""
        failure, self.failure = self.failure, None
        return failure


def _require_bearable(address: int, length: int) -> None:
    if length > LONGEST:
        raise RemoteProtocolError(
            f"the description has a register of {length} bytes at 0x{address:X}; at most {LONGEST} make sense"
        )
