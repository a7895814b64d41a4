"""A camera may refuse every register that it need not have: it is asked once, and streams.

harvesters 226 (the second URL), aravis 153 (SCSP). With GRABBERGUI_EVERY_STATUS=1 each register is refused
with each status, otherwise with two.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from contextlib import ExitStack, closing
from queue import Queue

import pytest

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.gige import bootstrap
from grabbergui.driver.gige.bootstrap import BootstrapRegister, StreamChannel
from grabbergui.driver.gige.device import GigeDevice
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.stream.channel import GigeOptions
from grabbergui.driver.gige.stream.packet_delay import PacketDelayPolicy
from grabbergui.driver.gige.stream.packet_size import PacketSizePolicy
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE

ADDRESS = f"127.13.{os.getpid() % 250 + 1}.1"
CHANNEL = StreamChannel(0)
MANDATORY = {BootstrapRegister.CCP, CHANNEL.port, CHANNEL.destination}
"Without them no stream can begin: who controls the camera, and where to it sends."
STATUSES = [*(status for status in Status if status >= 0x8001 and status is not Status.BUSY), 0xC123]
OPTIONS = GigeOptions(
    packet_size=PacketSizePolicy("fixed", 1400), packet_delay=PacketDelayPolicy(bytes_per_second=1e8)
)


@pytest.fixture
def camera() -> Iterator[GigeCamera]:
    power_on = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 200.0, reg.EXPOSURE_TIME: 100.0}
    with closing(GigeCamera(ADDRESS, power_on=power_on)) as camera:
        yield camera


def use(camera: GigeCamera, deviations: Deviations) -> Frame:
    """Open, describe, stream one frame and close, as every application does."""
    camera.control.deviations = deviations
    frames: Queue[Frame] = Queue()
    device = GigeDevice(ADDRESS, OPTIONS)
    with ExitStack() as stack:
        stack.callback(device.close)
        device.open(Access.CONTROL)
        device.use_description(device.description().decode())
        device.open_events()
        device.open_stream(StreamRequest(4096), frames.put)
        device.write(reg.ACQUISITION_START.address, reg.ACQUISITION_START.encode(1))
        frame = frames.get(timeout=PATIENCE)
        device.write(reg.ACQUISITION_STOP.address, reg.ACQUISITION_STOP.encode(1))
    return frame


def accesses(camera: GigeCamera, deviations: Deviations | None = None) -> list[int]:
    """Return the addresses of the standard's registers in the order in which they are accessed."""
    seen: list[int] = []
    channel = camera.control
    original = channel._require_access

    def noting(address: int, length: int) -> None:
        if address < 0x9000 or gev.ACTION_GROUP_KEY.address <= address < 0xA000:
            seen.append(address)
        original(address, length)

    channel._require_access = noting  # type: ignore[method-assign]
    try:
        use(camera, deviations or Deviations())
    finally:
        channel._require_access = original  # type: ignore[method-assign]
    return seen


def refuse(camera: GigeCamera, register: int, status: int) -> None:
    try:
        frame = use(camera, Deviations(refused={register: status}))
    except GrabberError as error:
        pytest.fail(f"0x{register:04X} refused with 0x{status:04X}: {type(error).__name__}: {error}")
    assert frame.raw().shape == (48, 64)


def test_each_register_may_be_refused(camera: GigeCamera) -> None:
    used = sorted(set(accesses(camera)))
    assert {
        BootstrapRegister.CCP,
        BootstrapRegister.GVCP_CAPABILITY,
        CHANNEL.packet_size,
        CHANNEL.source_port,
    } <= set(used)
    assert {bootstrap.FIRST_URL.address, BootstrapRegister.MCP, BootstrapRegister.LINK_SPEED} <= set(used), (
        used
    )
    optional = [*(set(used) - MANDATORY), bootstrap.SECOND_URL.address]
    if os.environ.get("GRABBERGUI_EVERY_STATUS"):
        cases = list(itertools.product(optional, STATUSES))
    else:
        cases = list(zip(sorted(optional) * 2, itertools.cycle(STATUSES), strict=False))
    for register, status in cases:
        refuse(camera, register, status)


def test_all_at_once(camera: GigeCamera) -> None:
    optional = set(accesses(camera)) - MANDATORY - {bootstrap.FIRST_URL.address}
    refused = dict.fromkeys([*optional, bootstrap.SECOND_URL.address], int(Status.INVALID_ADDRESS))
    assert use(camera, Deviations(refused=refused)).raw().shape == (48, 64)


def test_a_refused_register_is_asked_once(camera: GigeCamera) -> None:
    refused = {
        register: int(Status.NOT_IMPLEMENTED)
        for register in (
            BootstrapRegister.VERSION,
            BootstrapRegister.TICK_FREQUENCY_LOW,
            CHANNEL.source_port,
            BootstrapRegister.MCSP,
        )
    }
    seen = accesses(camera, Deviations(refused=refused))
    assert [seen.count(register) for register in refused] == [1] * len(refused)


@pytest.mark.parametrize("register", sorted(MANDATORY - {CHANNEL.destination}))
def test_one_without_which_nothing_works_is_named(camera: GigeCamera, register: int) -> None:
    with pytest.raises(GrabberError, match=f"0x{register:X}"):
        use(camera, Deviations(refused={register: int(Status.INVALID_ADDRESS)}))


def test_a_write_protected_packet_size_is_used_as_it_stands(camera: GigeCamera) -> None:
    camera.control.memory.set(gev.CHANNELS[0].scps, 576)
    camera._configure_stream()
    use(camera, Deviations(read_only=frozenset({CHANNEL.packet_size})))
    assert camera.control.memory.integer(gev.CHANNELS[0].scps) == 576


@pytest.mark.parametrize("longest", [256, 128, 64])
def test_memory_is_read_in_pieces_that_the_camera_allows(camera: GigeCamera, longest: int) -> None:
    assert use(camera, Deviations(longest_access=longest)).raw().shape == (48, 64)
    with closing(GigeDevice(ADDRESS)) as device:
        device.open(Access.CONTROL)
        assert len(device.read(bootstrap.FIRST_URL.address, 512)) == 512
        content = bytes(range(256)) * 2
        address = reg.FILE_ACCESS_BUFFER[0]
        device.write(address, content)
        assert device.read(address, 512) == content
