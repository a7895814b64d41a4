"""The node map's door to a device's registers."""

from __future__ import annotations

from genicam import genapi

from grabbergui.core.errors import GrabberError
from grabbergui.driver.device import Device


class RegisterPort(genapi.AbstractPort):
    """Reads and writes registers of a `Device` for GenApi.

    What the device raises does not survive its way through C++, so it is kept in `failure` for whoever
    made the call.
    """

    def __init__(self, device: Device) -> None:
        super().__init__()
        self._device = device
        self.failure: GrabberError | None = None
        "The last error, until taken by `take_failure`."

    def read(self, address: int, length: int) -> bytes:
        """Called by GenApi."""
        try:
            return self._device.read(address, length)
        except GrabberError as error:
            self.failure = error
            raise RuntimeError(str(error)) from error

    def write(self, address: int, value: bytes) -> None:
        """Called by GenApi."""
        try:
            self._device.write(address, bytes(value))
        except GrabberError as error:
            self.failure = error
            raise RuntimeError(str(error)) from error

    def get_access_mode(self) -> int:
        """Called by GenApi."""
        return int(genapi.EAccessMode.RW)

    def is_open(self) -> bool:
        """Called by GenApi."""
        return True

    def get_principal_interface_type(self) -> int:
        """Called by GenApi."""
        return int(genapi.EInterfaceType.intfIPort)

    def take_failure(self) -> GrabberError | None:
        """The error behind GenApi's last exception, forgotten by this call."""
        failure, self.failure = self.failure, None
        return failure
