"""A camera's identity from its bootstrap registers, over whichever library reads them.

GigE Vision 2.x, section 28 (registers 0x0000 to 0x00F7); GenCP 1.3, section 4 (ABRM).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device import DataLayout
from grabbergui.driver.gige.bootstrap import IDENTITY_BYTES
from grabbergui.driver.gige.discovery.search import NO_MAC
from grabbergui.driver.gige.gvcp_messages import Identity
from grabbergui.driver.u3v.bootstrap import STRING_SIZE, Abrm, string

_ABRM_STRINGS = {
    "vendor": Abrm.MANUFACTURER_NAME,
    "model": Abrm.MODEL_NAME,
    "version": Abrm.DEVICE_VERSION,
    "serial": Abrm.SERIAL_NUMBER,
    "user_name": Abrm.USER_DEFINED_NAME,
}


def with_identity(info: DeviceInfo, layout: DataLayout, read: Callable[[int, int], bytes]) -> DeviceInfo:
    """Return `info` with what the registers of an open camera say of it; fields they leave empty stay.

    `read` takes an address and a length in bytes. Raises what it raises, RemoteProtocolError.
    """
    if layout is DataLayout.GIGE_VISION:
        identity = Identity.decode(read(0, IDENTITY_BYTES))
        said = {name: getattr(identity, name) for name in _ABRM_STRINGS}
        said["hardware_id"] = identity.mac if identity.mac != NO_MAC else ""
    else:
        said = {name: string(read(address, STRING_SIZE)) for name, address in _ABRM_STRINGS.items()}
    return replace(info, **{name: text for name, text in said.items() if text})
