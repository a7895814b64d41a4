"""A USB3 camera may refuse registers, and its newest description may be damaged."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest

from grabbergui.core.errors import DeviceStatusError, GrabberError, RemoteProtocolError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.u3v.device import U3vRefusedError
from grabbergui.driver.u3v.bootstrap import Abrm, ManifestEntry, Sbrm, read_description
from grabbergui.driver.u3v.gencp import Status
from patience import PATIENCE

STATUSES = [status for status in Status if status >= 0x8001 and status is not Status.BUSY]
BOOTSTRAP = 0x10_0000
"The standard's registers are below."


def use(simulated: Any, device: Any, on_access: Callable[[int, bool], None]) -> Frame:
    """Open, stream a frame, close; `on_access` sees each access to the standard's registers."""
    read, write = simulated.registers.read, simulated.registers.write

    def reading(address: int, length: int) -> bytes:
        if address < BOOTSTRAP:
            on_access(address, False)
        return read(address, length)

    def writing(address: int, data: bytes) -> None:
        if address < BOOTSTRAP:
            on_access(address, True)
        write(address, data)

    simulated.registers.read, simulated.registers.write = reading, writing
    frames: Queue[Frame] = Queue()
    try:
        device.open(Access.CONTROL)
        device.open_stream(StreamRequest(64 * 48), frames.put)
        device.write(reg.ACQUISITION_START.address, (1).to_bytes(4, "little"))
        frame = frames.get(timeout=PATIENCE)
        device.write(reg.ACQUISITION_STOP.address, (1).to_bytes(4, "little"))
        return frame
    finally:
        simulated.registers.read, simulated.registers.write = read, write
        device.close()


def refusing(register: int, status: int) -> Callable[[int, bool], None]:
    def refuse(address: int, writing: bool) -> None:
        if address == register and not writing:
            raise U3vRefusedError(status)

    return refuse


def test_each_register_may_be_refused(plug_in: Any) -> None:
    simulated, device = plug_in()
    seen: set[int] = set()
    use(simulated, device, lambda address, writing: None if writing else seen.add(address))
    assert {Abrm.MAXIMUM_RESPONSE_TIME, Abrm.DEVICE_CAPABILITY, Abrm.USER_DEFINED_NAME} <= seen
    needed = {Abrm.SBRM_ADDRESS, *sirm_pointers(simulated)}
    optional = sorted(seen - needed)
    if os.environ.get("GRABBERGUI_EVERY_STATUS"):
        cases = list(itertools.product(optional, STATUSES))
    else:
        cases = list(zip(optional, itertools.cycle(STATUSES), strict=False))
    for register, status in cases:
        try:
            frame = use(simulated, device, refusing(register, status))
        except GrabberError as error:
            pytest.fail(f"0x{register:X} refused with {status.name}: {error}")
        assert frame.raw().shape == (48, 64)


def sirm_pointers(simulated: Any) -> set[int]:
    """Return where the address of the stream's registers is."""
    sbrm = int.from_bytes(simulated.registers.read(Abrm.SBRM_ADDRESS, 8), "little")
    return {sbrm + Sbrm.SIRM_ADDRESS}


XML = b"<RegisterDescription>old</RegisterDescription>"
OTHERS = {
    "a damaged archive": b"PK\3\4" + bytes(40),
    "broken XML": b"<RegisterDescription>new</Register",
    "nothing": b"",
}


def memory(*files: bytes, refused: bool = False) -> Callable[[int, int], bytes]:
    """A manifest whose files have rising versions."""
    at, entries = 0x1000, b""
    for version, file in enumerate(files):
        entries += ManifestEntry((1, version, 0), 0, 0, (1, 1), at, len(file)).encode()
        at += 0x1000
    table = len(files).to_bytes(8, "little") + entries

    def read(address: int, length: int) -> bytes:
        if address < 0x1000:
            return table[address - 0x100 :][:length]
        if refused and address == 0x1000 * len(files):
            raise DeviceStatusError("refused", 0x8003)
        return files[address // 0x1000 - 1][:length]

    return read


@pytest.mark.parametrize("newest", OTHERS.values(), ids=OTHERS)
def test_behind_a_damaged_newest_description_is_an_older_one(
    newest: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    assert read_description(memory(b"<a/>", XML, newest), 0x100) == XML
    assert read_description(memory(b"<a/>", XML), 0x100) == XML, "the newest, if it is whole"


def test_one_that_is_refused_likewise() -> None:
    assert read_description(memory(XML, b"<new/>", refused=True), 0x100) == XML


def test_broken_xml_alone_is_returned_for_the_parser_to_judge() -> None:
    assert read_description(memory(OTHERS["broken XML"]), 0x100) == OTHERS["broken XML"]


def test_none_at_all_names_each_problem() -> None:
    files = (OTHERS["a damaged archive"], OTHERS["nothing"])
    with pytest.raises(RemoteProtocolError, match=r"version 1\.1\.0: .*version 1\.0\.0: .*damaged"):
        read_description(memory(*files), 0x100)
