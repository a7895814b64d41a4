"""Byte order of registers: the simulated camera with each order and schema, as we and Aravis access it.

GenICam standard 2.1.1, appendix 3.1; the public reports are Aravis's issues 179, 203, 444, 490, 715 and 836.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import closing

import pytest

from grabbergui import sources
from grabbergui.core.errors import SourceUnavailableError
from grabbergui.core.grabber import Access
from grabbergui.core.uri import SourceUri
from grabbergui.driver.aravis import library
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.gige import quirks
from grabbergui.driver.gige.bootstrap import GvcpCapability
from grabbergui.driver.gige.device import GigeDevice, create
from grabbergui.driver.gige.identity import Identity, identity_of
from grabbergui.driver.gige.quirks import DescriptionTraits, Quirk
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.gige.server import GigeCamera

ADDRESS = f"127.12.{os.getpid() % 250 + 1}.1"

ORDERS = {
    "big-endian": Deviations(),
    "big-endian, schema 1.0": Deviations(schema=0),
    "little-endian": Deviations(little_endian=True),
    "little-endian, schema 1.0": Deviations(little_endian=True, schema=0),
    "little-endian, declared big-endian": Deviations(little_endian=True, declared_big_endian=True),
}
WITHOUT_WRITEMEM = {
    "big-endian": Deviations(absent=GvcpCapability.WRITEMEM),
    "little-endian": Deviations(little_endian=True, absent=GvcpCapability.WRITEMEM),
    "little-endian, schema 1.0": Deviations(little_endian=True, schema=0, absent=GvcpCapability.WRITEMEM),
}
EXPOSURE = 12345.5
"An eight-byte float; it cannot be right where a wrong order is declared for it."


@pytest.fixture(params=[*ORDERS, *(f"{name}, without WRITEMEM" for name in WITHOUT_WRITEMEM)])
def odd(request: pytest.FixtureRequest) -> Deviations:
    name, _, without = request.param.partition(", without")
    return (WITHOUT_WRITEMEM if without else ORDERS)[name]


@pytest.fixture
def served(odd: Deviations) -> Iterator[GigeCamera]:
    with closing(GigeCamera(ADDRESS, deviations=odd)) as camera:
        yield camera


@pytest.fixture
def camera(served: GigeCamera) -> Iterator[DeviceGrabber]:
    grabber = create(SourceUri.parse(f"gige:{ADDRESS}"))
    assert isinstance(grabber, DeviceGrabber)
    with closing(grabber):
        grabber.open(Access.CONTROL)
        yield grabber


def test_values_are_those_of_the_camera(served: GigeCamera, camera: DeviceGrabber, odd: Deviations) -> None:
    model = served.model.memory
    assert camera.feature("Width").value == model.integer(reg.WIDTH)
    assert camera.feature("DeviceSerialNumber").value == served.serial
    camera.write_feature("Width", 64)
    assert model.integer(reg.WIDTH) == 64 and camera.feature("Width").value == 64
    camera.write_feature("DeviceUserID", "front left")
    assert camera.feature("DeviceUserID").value == "front left"
    assert model.get(reg.DEVICE_USER_ID) == "front left"
    if not odd.declared_big_endian and not odd.absent:
        camera.write_feature("ExposureTime", EXPOSURE)
        assert model.number(reg.EXPOSURE_TIME) == EXPOSURE
        assert camera.feature("ExposureTime").value == EXPOSURE
    # Bits of the standard's registers, which Aravis and we write ourselves too.
    camera.write_feature("GevSCPSPacketSize", 576)
    assert served.control.memory.integer(gev.CHANNELS[0].scps) & 0xFFFF == 576
    assert camera.feature("GevCurrentIPAddress").value == served.control.memory.integer(gev.CURRENT_IP)


@pytest.mark.parametrize("odd", [ORDERS["little-endian"]])
def test_it_streams(served: GigeCamera, camera: DeviceGrabber) -> None:
    with closing(camera.open_queue(2)) as queue:
        camera.start()
        assert queue.get(5.0).width == served.model.memory.integer(reg.WIDTH)
        camera.stop()


# Aravis knows cameras that contradict themselves by a table of names, and WRITEMEM is its only way to write.
@pytest.mark.parametrize("odd", [odd for odd in ORDERS.values() if not odd.declared_big_endian])
def test_aravis_reads_and_writes_the_same(served: GigeCamera, odd: Deviations, gvcp_port: None) -> None:
    program = shutil.which("arv-tool-0.8")
    if program is None:
        pytest.skip("arv-tool-0.8 is not installed (Debian: aravis-tools-cli)")

    def control(*features: str) -> dict[str, str]:
        done = subprocess.run(
            [program, "-a", ADDRESS, "control", *features],
            capture_output=True,
            text=True,
            timeout=20,
            check=True,
        )
        return dict(re.findall(r"^(\w+) = (\S+)", done.stdout, re.MULTILINE))

    assert control("Width", "DeviceSerialNumber") == {
        "Width": str(served.model.memory.integer(reg.WIDTH)),
        "DeviceSerialNumber": served.serial,
    }
    control("Width=64", f"ExposureTime={EXPOSURE}")
    assert served.model.memory.integer(reg.WIDTH) == 64
    assert served.model.memory.number(reg.EXPOSURE_TIME) == EXPOSURE


@pytest.mark.aravis
@pytest.mark.parametrize("odd", [odd for odd in ORDERS.values() if odd.little_endian])
def test_our_node_map_behind_aravis_reads_and_writes_the_same(served: GigeCamera) -> None:
    try:
        library.load()
    except SourceUnavailableError as missing:
        pytest.skip(str(missing))
    grabber = sources.create(f"aravis:{ADDRESS}")
    with closing(grabber):
        grabber.open(Access.CONTROL)
        assert grabber.feature("Width").value == served.model.memory.integer(reg.WIDTH)
        grabber.write_feature("Width", 64)
        assert served.model.memory.integer(reg.WIDTH) == 64


@pytest.mark.parametrize("odd", [ORDERS["little-endian, declared big-endian"]])
def test_an_option_decides(served: GigeCamera) -> None:
    for option, width in (("numbers", 640), ("memory", int.from_bytes((640).to_bytes(4, "little"), "big"))):
        served.control.release()
        served.model.memory.set(reg.WIDTH, 640)
        grabber = create(SourceUri.parse(f"gige:{ADDRESS}?registers={option}"))
        with closing(grabber):
            grabber.open(Access.MONITOR)
            assert grabber.feature("Width").value == width


@pytest.mark.parametrize("odd", [ORDERS["little-endian"]])
def test_the_address_is_kept_in_the_right_order(served: GigeCamera) -> None:
    """It was written as the bytes of a big-endian camera."""
    from grabbergui.driver.gige.address_commands import keep_address

    with closing(GigeDevice(ADDRESS)) as device:
        device.open(Access.CONTROL)
        keep_address(device, "10.1.2.3", "255.255.255.0")
    assert served.control.memory.integer(gev.PERSISTENT_IP) == 0x0A010203


@pytest.mark.parametrize("odd", [ORDERS["little-endian"]])
def test_the_identity_is_read_from_the_memory(served: GigeCamera) -> None:
    with closing(GigeDevice(ADDRESS)) as device:
        device.open(Access.MONITOR)
        read = identity_of(device.read)
    assert read == Identity.decode(gev.identity(served.control.memory))
    assert read.ip == ADDRESS and read.device_mode == 0x1


def description(vendor: str, model: str, minor: int, order: str) -> str:
    return f"""<RegisterDescription ModelName="{model}" VendorName="{vendor}" SchemaMajorVersion="1"
    SchemaMinorVersion="{minor}"><IntReg Name="A"><pPort>Device</pPort><Endianess>{order}</Endianess></IntReg>
    <IntReg Name="B"><pPort>Chunk</pPort><Endianess>LittleEndian</Endianess></IntReg>
    </RegisterDescription>"""


@pytest.mark.parametrize("little", [False, True])
def test_schema_and_table_decide(little: bool) -> None:
    def numbers(vendor: str, model: str, minor: int, order: str) -> bool:
        traits = DescriptionTraits.of(description(vendor, model, minor, order))
        return traits.numbers(little_endian=little)

    assert numbers("Basler", "GigECamera", 0, "BigEndian")
    assert not numbers("HIKROBOT", "HIKCamera", 1, "LittleEndian")
    assert numbers("Basler", "GigECamera", 1, "BigEndian") is little, "contradicts DeviceMode"
    assert numbers("Sony", "XCG_CPSeries", 1, "BigEndian")
    assert not numbers("Sony", "another", 1, "LittleEndian")


def test_each_row_of_the_table_names_a_camera_and_its_evidence() -> None:
    rows = quirks.KNOWN_CAMERAS
    assert len({(row.quirk, row.vendor, row.model) for row in rows}) == len(rows)
    assert all(row.vendor and row.model and row.evidence for row in rows)
    kinds = {row.vendor for row in rows if row.quirk is Quirk.NUMBERS}
    assert {"DO3THINK", "EVK", "FLIR", "Imperx", "NIT", "Sony", "Xenics"} <= kinds
