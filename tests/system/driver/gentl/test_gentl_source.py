"""GenTL sources on the simulated producer that the `genicam` package ships: three cameras, 400×400."""

import gc
import json
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import genicam
import numpy as np
import pytest

from grabbergui import sources
from grabbergui.cli import main
from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    MissingFileError,
    OtherCameraError,
    SourceNotFoundError,
    SourceUnavailableError,
    UsageError,
)
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.driver.gentl import device, producer
from grabbergui.driver.gentl import stream as gentl_stream
from grabbergui.driver.gentl.module_registers import choose_order_mechanism
from grabbergui.driver.gentl.stream import BUFFERS
from patience import PATIENCE, TRIES, until

VIKY = Path(genicam.__file__).parent / "viky.cti"
pytestmark = pytest.mark.skipif(not VIKY.is_file(), reason="this build of genicam ships no viky.cti")


@pytest.fixture
def grabber():
    camera = sources.create(f"gentl:{VIKY}")
    camera.open()
    yield camera
    camera.close()


def test_grab_counts_frames(capsys):
    assert main(["grab", f"gentl:{VIKY}", "-n", "40", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["frames"], summary["incomplete"], summary["lost"]) == (40, 0, 0)
    assert (summary["width"], summary["height"], summary["pixel_format"]) == (400, 400, "RGBa8")


def test_without_the_environment_variable_no_producer_is_loaded(monkeypatch):
    monkeypatch.delenv(device.SEARCH_PATH, raising=False)
    assert device.discover(0.1) == []
    assert not producer.Producer._open


def test_discovery_lists_each_camera_under_a_uri_that_opens_it(monkeypatch):
    monkeypatch.setenv(device.SEARCH_PATH, str(VIKY.parent))
    found = device.discover(0.2)
    assert [info.address for info in found] == [f"VikyTL_DEV_{name}" for name in ("red", "green", "blue")]
    camera = sources.create(found[1].uri)
    camera.open()
    try:
        assert camera.info == found[1]
    finally:
        camera.close()
    assert not producer.Producer._open


def test_a_producer_that_cannot_be_loaded_hinders_no_other(monkeypatch, tmp_path, caplog):
    broken = tmp_path / "broken.cti"
    broken.write_bytes(b"no library")
    monkeypatch.setenv(device.SEARCH_PATH, f"{tmp_path}:/nowhere:{VIKY}")
    assert len(device.discover(0.2)) == 3
    assert "broken.cti" in caplog.text
    with pytest.raises(SourceUnavailableError, match=r"broken\.cti"):
        sources.create(f"gentl:{broken}").open()


@pytest.mark.parametrize("name", ["VikyTL_DEV_blue", "2"])
def test_a_camera_is_named_by_its_id_or_serial_number(monkeypatch, name):
    monkeypatch.setenv(device.SEARCH_PATH, str(VIKY.parent))
    camera = sources.create(f"gentl:viky.cti#{name}")
    camera.open()
    try:
        assert camera.info.address == "VikyTL_DEV_blue"
        assert camera.info.uri == f"gentl:viky.cti#{name}"
    finally:
        camera.close()


def test_a_producer_that_opens_another_camera_than_the_named_one_is_found_out(monkeypatch):
    """As one was seen to do: the list says blue, what is opened under it is red."""
    cameras = producer.Producer.cameras

    def confused(self, *arguments):
        red, green, blue = cameras(self, *arguments)
        return [red, green, producer.FoundCamera(red.info, blue.device)]

    monkeypatch.setattr(producer.Producer, "cameras", confused)
    monkeypatch.setattr(producer.FoundCamera, "answers_to", lambda self, name: self.device.serial == name)
    with pytest.raises(OtherCameraError, match=r"VikyTL_DEV_red instead of .*serial 2.*VikyTL_DEV_blue"):
        sources.create(f"gentl:{VIKY}#2").open()
    assert not producer.Producer._open, "the other camera was closed again"


def test_a_name_that_two_cameras_have_opens_neither_and_names_both(monkeypatch):
    monkeypatch.setattr(producer.FoundCamera, "answers_to", lambda self, name: True)
    with pytest.raises(OtherCameraError, match=r"#VikyTL_DEV_red.*#VikyTL_DEV_green.*#VikyTL_DEV_blue"):
        sources.create(f"gentl:{VIKY}#twin").open()


def test_another_camera_listed_under_the_name_of_the_one_met_is_refused(monkeypatch):
    camera = sources.create(f"gentl:{VIKY}#2")
    camera.open()
    camera.close()
    monkeypatch.setattr(producer.FoundCamera, "answers_to", lambda self, name: self.device.serial == "1")
    with pytest.raises(OtherCameraError, match=r"VikyTL_DEV_green.*serial 1.*serial 2"):
        camera.open()


def test_wrong_names_say_what_there_is(monkeypatch):
    monkeypatch.delenv(device.SEARCH_PATH, raising=False)
    with pytest.raises(MissingFileError, match=r"nix\.cti.*GENICAM_GENTL64_PATH"):
        sources.create("gentl:nix.cti")
    with pytest.raises(MissingFileError):
        sources.create(f"gentl:{5000 * 'x'}.cti")
    with pytest.raises(UsageError, match="no option fps; there is only description"):
        sources.create(f"gentl:{VIKY}?fps=3")
    with pytest.raises(SourceNotFoundError, match=r"'9'.*VikyTL_DEV_red"):
        sources.create(f"gentl:{VIKY}#9").open()


def test_features_are_read_and_written(grabber):
    assert grabber.feature("AcquisitionFrameRate").value == pytest.approx(20)
    rate = grabber.feature("AcquisitionFrameRate")
    assert grabber.write_feature("AcquisitionFrameRate", rate.value / 2).value == pytest.approx(10)


def test_two_cameras_of_one_producer_stream_at_once(grabber):
    other = sources.create(f"gentl:{VIKY}#VikyTL_DEV_blue")
    other.open()
    try:
        queues = [camera.open_queue(8) for camera in (grabber, other)]
        for camera in (grabber, other):
            camera.start()
        images = [queue.get(PATIENCE).rgb() for queue in queues]
    finally:
        other.close()
    assert not np.array_equal(*images)
    assert queues[0].get(PATIENCE).complete  # the other's end did not end this one's


def test_frames_keep_their_memory_and_give_it_back(grabber):
    queue = grabber.open_queue(2 * BUFFERS)
    grabber.start()
    held = [queue.get(PATIENCE) for _ in range(3)]
    copies = [frame.raw().copy() for frame in held]
    for _ in range(BUFFERS + 2):
        queue.get(PATIENCE)
    grabber.close()
    gc.collect()
    for frame, copy in zip(held, copies, strict=True):
        assert np.array_equal(frame.raw(), copy)
        assert not frame.payload.flags.writeable


def test_a_wait_for_frames_leaves_the_interpreter_to_others(grabber):
    """The binding keeps the GIL while it waits; other threads must not notice."""
    queue = grabber.open_queue()
    grabber.start()
    queue.get(PATIENCE)
    for _ in range(TRIES):
        before = grabber.statistics().frames
        idle, long_pauses, last = threading.Event(), 0, time.monotonic()
        while (frames := grabber.statistics().frames - before) < 16:
            idle.wait(0.001)
            now = time.monotonic()
            long_pauses, last = long_pauses + (now - last > 0.03), now
        # A waiting call would take most of every frame's 50 ms; a busy machine takes some.
        if long_pauses < frames / 2:
            break
    assert long_pauses < frames / 2


def test_only_one_controls_a_camera_at_a_time(grabber):
    second = sources.create(f"gentl:{VIKY}")
    with pytest.raises(AccessDeniedError):
        second.open()
    assert grabber.feature("Width").value == 400


def test_refused_registers_and_a_closed_camera_say_so(grabber):
    device = grabber.device
    with pytest.raises(DeviceStatusError) as refusal:
        device.read(0x99999999, 4)
    assert refusal.value.status == -1005
    grabber.close()
    with pytest.raises(DeviceLostError, match="not open"):
        device.read(0, 4)


def test_a_missing_function_is_reported_in_the_producers_words():
    with pytest.raises(DeviceStatusError, match="Read-only device access not implemented"):
        sources.create(f"gentl:{VIKY}").open(Access.MONITOR)
    assert not producer.Producer._open


@pytest.mark.parametrize("entry", ["x" * 5000, "no\N{NULL}path", "/proc/1/root/none"])
def test_entries_of_the_search_path_that_are_no_paths_hinder_no_other(monkeypatch, entry):
    monkeypatch.setattr(device.os, "environ", {device.SEARCH_PATH: f"{entry}:{VIKY}"})
    assert device.installed_producers() == [VIKY]


def test_a_producer_need_not_say_whether_frames_are_complete(grabber, monkeypatch):
    def not_reported(buffer):
        raise producer.gentl.GenericException("not available (ID: -1014)")

    monkeypatch.setattr(producer.gentl.Buffer, "is_complete", not_reported)
    queue = grabber.open_queue(1)
    grabber.start()
    for _ in range(2 * BUFFERS):
        assert queue.get(PATIENCE).complete


def test_a_camera_lost_while_streaming_is_reported_once(grabber, monkeypatch, caplog):
    def gone(manager, timeout):
        raise producer.gentl.IoException("Message from the source: unplugged) (ID: -1010)")

    states = []
    grabber.connection_changed.connect(lambda state, reason: states.append((state, reason)))
    # Not by what else may notice: nobody listens to features, and none is read.
    queue = grabber.open_queue(1)
    grabber.start()
    queue.get(PATIENCE)
    monkeypatch.setattr(producer.gentl.EventManagerNewBuffer, "update_event_data", gone)
    until(lambda: states)
    monkeypatch.undo()
    assert states[0][0] is ConnectionState.LOST
    assert caplog.text.count("receiving:") == 1
    queue.get(PATIENCE)  # it is opened again, and streams


def test_a_camera_for_which_the_producer_only_times_out_is_lost(grabber, monkeypatch):
    def silent(*arguments):
        raise producer.gentl.TimeoutException("Message from the source: no answer) (ID: -1011)")

    def slow(*arguments):
        writes.append(arguments)
        raise producer.gentl.TimeoutException("Message from the source: no answer) (ID: -1011)")

    states, writes = [], []
    grabber.connection_changed.connect(lambda state, reason: states.append(state))
    with monkeypatch.context() as answers_reads:
        answers_reads.setattr(producer.gentl.Port, "write", slow)
        with pytest.raises(AckTimeoutError):
            grabber.device.write(0, bytes(4))
        assert writes and not states
    with monkeypatch.context() as answers_nothing:
        answers_nothing.setattr(producer.gentl.Port, "write", silent)
        answers_nothing.setattr(producer.gentl.Port, "read", silent)
        with pytest.raises(DeviceLostError, match="no answer"):
            grabber.device.write(0, bytes(4))
        assert states == [ConnectionState.LOST]
    until(lambda: states[-1] is ConnectionState.OPEN, "its return")


def test_no_buffer_is_lost_where_the_producer_fails(grabber, monkeypatch):
    made = gentl_stream.GentlStream._frame
    failures = iter(range(2 * BUFFERS))

    def failing(self, buffer, index):
        if next(failures, None) is not None:
            raise producer.gentl.GenericException("failed (ID: -1001)")
        return made(self, buffer, index)

    monkeypatch.setattr(gentl_stream, "ERRORS_IN_A_ROW", 10_000)
    monkeypatch.setattr(gentl_stream.GentlStream, "_frame", failing)
    queue = grabber.open_queue(1)
    grabber.start()
    assert queue.get(PATIENCE).complete


def test_a_buffer_that_the_producer_does_not_take_is_offered_again(grabber, monkeypatch):
    queue_buffer = producer.gentl.DataStream.queue_buffer
    failures = []

    def failing(self, buffer):
        if len(failures) < BUFFERS + 2:
            failures.append(buffer)
            raise producer.gentl.GenericException("failed (ID: -1001)")
        queue_buffer(self, buffer)

    queue = grabber.open_queue(1)
    grabber.start()
    queue.get(PATIENCE)
    monkeypatch.setattr(producer.gentl.DataStream, "queue_buffer", failing)
    monkeypatch.setattr(gentl_stream, "ERRORS_IN_A_ROW", 10_000)
    until(lambda: len(failures) == BUFFERS + 2, "the last failure")
    queue.clear()
    assert queue.get(PATIENCE).complete


class LocalModule:
    """The producer's own module of a device, with one register: how the camera's registers are accessed."""

    XML = b"""<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="TL" VendorName="TL"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Category Name="Root"><pFeature>DeviceEndianessMechanism</pFeature></Category>
<Enumeration Name="DeviceEndianessMechanism"><EnumEntry Name="Legacy"><Value>0</Value></EnumEntry>
<EnumEntry Name="Standard"><Value>1</Value></EnumEntry><pValue>Mechanism</pValue></Enumeration>
<IntReg Name="Mechanism"><Address>0x10</Address><Length>4</Length><AccessMode>RW</AccessMode>
<pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>LittleEndian</Endianess></IntReg><Port Name="Device"/>
</RegisterDescription>"""

    def __init__(self):
        self.mechanism = b"\xff\0\0\0"
        self.url_info_list = [SimpleNamespace(url=f"Local:tl.xml;1000;{len(self.XML):x}")]

    def read(self, address, length):
        data = self.XML[address - 0x1000 :] if address >= 0x1000 else self.mechanism
        return length, data[:length]

    def write(self, address, data):
        assert address == 0x10
        self.mechanism = bytes(data)


@pytest.mark.parametrize(("numbers", "value"), [(True, 0), (False, 1)])
def test_a_producer_is_expected_how_registers_are_accessed(numbers, value):
    module = LocalModule()
    choose_order_mechanism(SimpleNamespace(local_port=module), numbers=numbers)
    assert int.from_bytes(module.mechanism, "little") == value


def test_a_producer_that_only_shows_how_it_accesses_registers_keeps_its_way():
    """Baumer's producer for GigE Vision (GAPI 2.9); its cameras could not be opened."""
    module = LocalModule()
    module.XML = module.XML.replace(b"<AccessMode>RW<", b"<AccessMode>RO<")
    module.url_info_list = [SimpleNamespace(url=f"Local:tl.xml;1000;{len(module.XML):x}")]
    module.mechanism = b"\1\0\0\0"
    choose_order_mechanism(SimpleNamespace(local_port=module), numbers=True)
    assert module.mechanism == b"\1\0\0\0"


@pytest.mark.parametrize(("kind", "expected"), [("GEV", [True]), ("U3V", [])])
def test_only_gige_cameras_have_two_ways(grabber, monkeypatch, kind, expected):
    heard = []
    monkeypatch.setattr(grabber.device, "_transport_layer", kind)
    monkeypatch.setattr(device, "choose_order_mechanism", lambda device, *, numbers: heard.append(numbers))
    grabber.device.use_description('<RegisterDescription SchemaMajorVersion="1" SchemaMinorVersion="0">')
    assert heard == expected
