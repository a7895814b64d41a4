"""The node map over a register memory: values, refusals, changes, odd nodes."""

import threading
from pathlib import Path

import pytest

from fakes import XmlDevice
from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceStatusError,
    FeatureAccessError,
    FeatureError,
    FeatureValueError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.core.features import AccessMode, FeatureKind, Representation, Visibility
from grabbergui.driver.genapi.node_map import CameraNodeMap
from patience import PATIENCE

XML = (Path(__file__).parents[3] / "data" / "genapi" / "test_camera.xml").read_bytes()


class Memory(XmlDevice):
    """Registers, one of which fails, and a wire that can go silent."""

    def __init__(self) -> None:
        super().__init__(XML)
        self.reads = 0
        self.silent = False
        self.refuse_writes = False
        self.word(0, 640)
        self.word(4, 2048)
        self.word(0x10, 100)

    def word(self, address: int, value: int) -> None:
        self.memory.update(enumerate(value.to_bytes(4, "big"), address))

    def read(self, address: int, length: int) -> bytes:
        self.reads += 1
        if self.silent:
            raise AckTimeoutError("no answer")
        if address == 0xF000:
            raise DeviceStatusError("register 0xF000: INVALID_ADDRESS", 0x8003)
        return super().read(address, length)

    def write(self, address: int, data: bytes) -> None:
        if self.silent:
            raise AckTimeoutError("no answer")
        if self.refuse_writes:
            raise DeviceStatusError(f"register 0x{address:X}: WRITE_PROTECT", 0x8004)
        super().write(address, data)


@pytest.fixture
def memory():
    return Memory()


@pytest.fixture
def changes():
    return []


@pytest.fixture
def nodes(memory, changes):
    nodes = CameraNodeMap(memory, memory.description(), changes.append)
    yield nodes
    nodes.close()


def test_the_tree_has_what_is_implemented(nodes):
    image, odd, *_ = nodes.root.members

    assert (image.name, image.title, image.visibility) == ("Image", "Image Format", Visibility.BEGINNER)
    assert [member.name for member in image.members] == [
        "Width", "WidthMax", "Big", "Gain", "Mode", "Reset", "Hidden",
    ]  # fmt: skip
    assert [member.name for member in odd.members] == ["Broken", "Fine"]
    assert not nodes.has("Absent")


def test_a_category_that_nothing_leads_to_is_found(nodes):
    lost = nodes.root.members[2]

    assert [member.name for member in lost.members] == ["GainRaw"]
    assert nodes.feature("GainRaw").representation is Representation.LINEAR


def test_what_operators_look_for_is_found_though_no_category_lists_it(nodes):
    unlisted = nodes.root.members[-1]

    assert [member.name for member in unlisted.members] == ["AcquisitionFrameRateRaw"]


def test_an_integer(nodes):
    width = nodes.feature("Width")

    assert (width.kind, width.value, width.minimum, width.maximum, width.increment) == (
        FeatureKind.INTEGER, 640, 16, 2048, 4,
    )  # fmt: skip
    assert (width.unit, width.access, width.tooltip) == ("px", AccessMode.READ_WRITE, "Columns")


def test_a_float_over_a_converter(nodes, memory):
    gain = nodes.feature("Gain")
    assert (gain.value, gain.minimum, gain.maximum, gain.unit) == (1.0, 0.5, 48.25, "dB")
    assert gain.representation is Representation.LOGARITHMIC and gain.visibility is Visibility.GURU

    nodes.write("Gain", 12.34)

    assert memory.writes[-1] == (0x10, (1234).to_bytes(4, "big"))
    assert nodes.feature("Gain").value == pytest.approx(12.34)


@pytest.mark.parametrize("value", [2**63 - 1, -(2**63), 2**53 + 1])
def test_64_bit_integers_are_exact(nodes, memory, value):
    nodes.write("Big", value)

    assert nodes.feature("Big").value == value
    assert memory.writes[-1] == (8, value.to_bytes(8, "big", signed=True))


def test_an_enumeration(nodes):
    mode = nodes.feature("Mode")

    assert mode.value == "Off"
    assert [(e.name, e.display_name, e.available) for e in mode.entries] == [
        ("Off", "Off", True), ("On", "Switched on", True), ("Never", "Never", False),
    ]  # fmt: skip


def test_one_write_changes_what_hangs_on_it(nodes, changes):
    assert nodes.feature("Hidden").access is AccessMode.NOT_AVAILABLE

    nodes.write("Mode", "On")

    assert {"Mode", "Hidden", "Fine"} <= set().union(*changes)
    assert nodes.feature("Hidden").value == 640
    assert nodes.feature("Fine").value is True


def test_changes_before_a_refusal_are_reported(nodes, memory, changes):
    """A mode is switched off for a write that the camera then refuses: the mode has changed all the same."""
    with pytest.raises(FeatureError, match="WRITE_PROTECT"), nodes.exclusive():
        nodes.write("Mode", "On")
        memory.refuse_writes = True
        nodes.write("Width", 644)

    assert {"Mode", "Hidden", "Fine"} <= set().union(*changes)


def test_a_locked_feature_is_read_only(nodes):
    nodes.write("Lock", 1)

    assert nodes.feature("Gain").access is AccessMode.READ_ONLY
    with pytest.raises(FeatureAccessError, match="Gain=2"):
        nodes.write("Gain", 2.0)


def test_cached_values_cost_no_reads(nodes, memory):
    nodes.feature("Width")
    before = memory.reads

    for _ in range(100):
        nodes.feature("Width")

    assert memory.reads == before


def test_a_failing_register_spoils_its_own_feature_only(nodes):
    broken = nodes.feature("Broken")

    assert broken.access is AccessMode.NOT_AVAILABLE and broken.problem
    assert nodes.feature("Fine").value is False


def test_out_of_range_names_the_range(nodes):
    with pytest.raises(FeatureValueError, match=r"Width=9999: .*16 … 2048 px, step 4"):
        nodes.write("Width", 9999)


def test_the_cameras_own_refusal_is_reported(nodes, memory):
    memory.refuse_writes = True

    with pytest.raises(FeatureError, match=r"Width=644: the camera answered: .*WRITE_PROTECT"):
        nodes.write("Width", 644)


def test_silence_is_a_transport_error(nodes, memory):
    memory.silent = True

    with pytest.raises(AckTimeoutError):
        nodes.execute("Reset")


def test_what_nobody_foresaw_is_a_transport_error_too(nodes, memory, monkeypatch):
    def fail(address, data):
        raise MemoryError("none left")

    monkeypatch.setattr(memory, "write", fail)

    with pytest.raises(TransportError, match="MemoryError: none left"):
        nodes.execute("Reset")


def test_commands(nodes, memory):
    nodes.execute("Reset")
    assert memory.writes[-1] == (0x18, b"\0\0\0\x01")

    with pytest.raises(FeatureAccessError, match="Width is no command"):
        nodes.execute("Width")


def test_two_threads_do_not_lock_each_other_out(memory):
    """Without one Python lock, a change reported on one thread and a read on another wait for ever."""
    slow = threading.Event()
    nodes = CameraNodeMap(memory, memory.description(), lambda names: slow.wait(0.0001))

    def write() -> None:
        for value in range(16, 400, 4):
            nodes.write("Width", value)

    def read() -> None:
        for _ in range(300):
            nodes.invalidate(frozenset({"Width", "Gain"}))
            nodes.feature("Gain")

    threads = [threading.Thread(target=target) for target in (write, read, read)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)

    assert not any(thread.is_alive() for thread in threads)
    assert nodes.feature("Width").value == 396
    nodes.close()


@pytest.mark.parametrize(
    "xml", [b"", b"\0" * 100, b"<html></html>", XML[:900], XML.replace(b"Converter", b"Con")]
)
def test_what_is_no_description_is_refused(xml):
    with pytest.raises(RemoteProtocolError, match="description"):
        CameraNodeMap(XmlDevice(xml), xml, lambda names: None)


def test_an_invalidated_feature_is_read_again_from_its_register(memory, nodes):
    assert nodes.feature("Width").value == 640
    memory.word(0, 320)
    assert nodes.feature("Width").value == 640, "from the cache"
    nodes.invalidate(frozenset({"Width"}))
    assert nodes.feature("Width").value == 320
