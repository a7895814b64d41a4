"""The camera as a frame grabber, on the simulated device."""

import re
import threading
from contextlib import closing, nullcontext

import pytest

from grabbergui import sources
from grabbergui.core.errors import (
    FeatureAccessError,
    FeatureError,
    FeatureNotFoundError,
    FeatureValueError,
)
from grabbergui.core.features import AccessMode
from grabbergui.core.grabber import Access
from grabbergui.core.settings import SettingKey
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.genapi.node_features import NodeFeature
from grabbergui.driver.genapi.node_map import CameraNodeMap
from patience import PATIENCE, attempts, until


def next_frames(queue, count):
    return [queue.get(PATIENCE) for _ in range(count)]


def test_opening_writes_nothing(monkeypatch):
    grabber = sources.create("sim:")
    written = []
    # Kept rather than raised: what a port raises does not survive its way through GenApi.
    monkeypatch.setattr(grabber.device, "write", lambda *arguments: written.append(arguments))
    grabber.open()
    grabber.features()
    grabber.close()

    assert written == []


def test_reading_under_another_selector_reports_no_change(camera):
    camera.write_feature("TriggerSelector", "FrameStart")
    reported = []
    camera.features_changed.connect(reported.append)

    assert (
        camera.read_setting(SettingKey.parse("TriggerDelay[TriggerSelector=FrameBurstStart]")).value
        is not None
    )
    assert camera.feature("TriggerSelector").value == "FrameStart"
    assert reported == []

    camera.write_setting(SettingKey.parse("TriggerDelay[TriggerSelector=FrameBurstStart]"), 1.5)
    assert "TriggerDelay" in frozenset().union(*reported)


def test_starting_changes_the_modes_and_nothing_else(camera):
    camera.write_feature("AcquisitionMode", "SingleFrame")
    camera.write_feature("TriggerSelector", "FrameBurstStart")
    camera.write_feature("TriggerMode", "On")
    camera.write_feature("TriggerSelector", "FrameStart")
    before = {feature.name: feature.value for feature in camera.features() if feature.streamable}

    camera.start()

    after = {feature.name: feature.value for feature in camera.features() if feature.streamable}
    assert {name for name in before if before[name] != after[name]} <= {"AcquisitionMode", "TriggerMode"}
    assert after["AcquisitionMode"] == "Continuous"
    camera.write_feature("TriggerSelector", "FrameBurstStart")
    assert camera.feature("TriggerMode").value == "Off"


@pytest.mark.parametrize(
    "missing, message",
    [
        (("Width", "PixelFormat"), None),
        (("PayloadSize", "PixelFormat"), None),
        (("PayloadSize", "Width"), "neither PayloadSize nor Width and Height"),
        (("AcquisitionStart",), "has no command AcquisitionStart"),
    ],
)
def test_a_description_without_usual_features_streams_or_says_what_is_missing(missing, message):
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    xml = grabber.device.description()
    for name in missing:
        xml = re.sub(rb"\b%s\b" % name.encode(), b"Other" + name.encode(), xml)
    grabber.device.description = lambda: xml
    with closing(grabber):
        grabber.open()
        frames = grabber.open_queue()
        if message is None:
            grabber.start()
            assert frames.get(PATIENCE).width == 64
        else:
            with pytest.raises(FeatureError, match=message):
                grabber.start()
            assert not grabber.streaming


def test_the_trigger_can_be_kept(camera):
    camera.write_feature("TriggerMode", "On")
    camera.start(keep_trigger=True)

    assert camera.feature("TriggerMode").value == "On"


def test_frames_flow_and_are_counted(camera):
    queue = camera.open_queue(500)  # on a busy machine none may be dropped
    camera.start()

    frames = next_frames(queue, 5)

    assert [frame.frame_id for frame in frames] == list(range(frames[0].frame_id, frames[0].frame_id + 5))
    assert all(frame.complete and frame.raw().shape == (48, 64) for frame in frames)
    assert camera.statistics().frames >= 5
    camera.stop()
    assert not camera.streaming


def test_writing_a_value_switches_its_automatic_mode_off(camera):
    camera.write_feature("ExposureAuto", "Continuous")
    assert camera.feature("ExposureTime").access is AccessMode.READ_ONLY

    assert camera.write_feature("ExposureTime", 1234).value == 1234
    assert camera.feature("ExposureAuto").value == "Off"


def test_a_wrong_value_switches_nothing_off(camera):
    camera.write_feature("ExposureAuto", "Continuous")

    with pytest.raises(FeatureValueError, match="ExposureTime=-5"):
        camera.write_feature("ExposureTime", -5)

    assert camera.feature("ExposureAuto").value == "Continuous"


def test_a_frame_rate_turns_its_switch_on(camera):
    camera.write_feature("AcquisitionFrameRateEnable", False)

    assert camera.write_feature("AcquisitionFrameRate", 12.5).value == 12.5
    assert camera.feature("AcquisitionFrameRateEnable").value is True


@pytest.mark.parametrize(
    ("name", "value"), [("PixelFormat", "BayerRG12p"), ("Width", 128), ("BinningVertical", 2)]
)
def test_what_changes_the_payload_restarts_the_stream(camera, name, value):
    queue = camera.open_queue(2)
    camera.start()
    queue.get(PATIENCE)

    before = camera.feature(name).value
    for watch in attempts(1.0):
        camera.write_feature(name, before)
        with watch:
            assert camera.write_feature(name, value).value == value
            queue.clear()
            frame = queue.get(PATIENCE)
    assert (frame.width, frame.height, frame.pixel_format.name) == tuple(
        camera.feature(feature).value for feature in ("Width", "Height", "PixelFormat")
    )
    assert frame.raw().shape == (frame.height, frame.width)


def test_a_refused_format_leaves_the_stream_on(camera):
    queue = camera.open_queue(2)
    camera.start()

    with pytest.raises(FeatureValueError, match="PixelFormat=Mono9"):
        camera.write_feature("PixelFormat", "Mono9")

    queue.clear()
    assert queue.get(PATIENCE).pixel_format.name == "Mono8"


def test_a_camera_that_refuses_to_stop_for_a_write_streams_on(camera, monkeypatch):
    queue = camera.open_queue(2)
    camera.start()

    def refuse(nodes, name):
        monkeypatch.undo()
        raise FeatureAccessError("the camera is busy", name)

    monkeypatch.setattr(CameraNodeMap, "execute", refuse)
    with pytest.raises(FeatureAccessError, match="busy"):
        camera.write_feature("Width", 128)

    assert camera.streaming
    queue.clear()
    assert queue.get(PATIENCE).width == 64


@pytest.mark.parametrize("refused", ["AcquisitionStop", "TLParamsLocked"])
def test_a_camera_that_refused_to_stop_is_stopped_later(camera, monkeypatch, refused):
    camera.start()
    nodes = camera._opened()
    execute, write = nodes.execute, nodes.write
    refusals = [FeatureError(f"{refused}: the camera answered: busy", refused)]

    def refuse_once(act):
        def acting(name, *value):
            if name == refused and refusals:
                raise refusals.pop()
            act(name, *value)

        return acting

    monkeypatch.setattr(nodes, "execute", refuse_once(execute))
    monkeypatch.setattr(nodes, "write", refuse_once(write))
    with pytest.raises(FeatureError) if refused == "AcquisitionStop" else nullcontext():
        camera.stop()
    assert not camera.streaming and not refusals

    assert camera.write_feature("PixelFormat", "Mono16").value == "Mono16"
    assert not camera.streaming and camera.feature("TLParamsLocked").value == 0


def test_a_value_under_its_automatic_mode_is_reported(camera):
    reported = set()
    seen = threading.Event()

    def note(names: frozenset[str]) -> None:
        reported.update(names)
        if "ExposureTime" in reported:
            seen.set()

    camera.write_feature("ExposureTime", 100)
    camera.features_changed.connect(note)
    camera.start()
    camera.write_feature("ExposureAuto", "Continuous")
    reported.clear()
    seen.clear()

    assert seen.wait(PATIENCE)
    until(lambda: camera.feature("ExposureTime").value > 100)


def test_a_listener_that_is_dropped_meanwhile_keeps_no_news_from_the_others(camera):
    """psygnal raises this where another thread removes a listener during the call."""
    reported = []

    def gone(_: frozenset[str]) -> None:
        camera.features_changed.disconnect(gone)
        raise ReferenceError("weakly-referenced object no longer exists")

    camera.features_changed.connect(gone)
    camera.features_changed.connect(reported.append)
    camera.write_feature("Gain", 3.0)
    assert any("Gain" in names for names in reported)


def test_read_only_beside_another_application():
    grabber = sources.create("sim:")
    grabber.open(Access.MONITOR)

    assert grabber.feature("Gain").access is AccessMode.READ_ONLY
    with pytest.raises(FeatureAccessError, match="open for reading only"):
        grabber.write_feature("Gain", 1)
    with pytest.raises(FeatureAccessError, match="open for reading only"):
        grabber.execute("TriggerSoftware")
    grabber.close()


def test_the_lock_of_the_transport_is_the_stream_s_alone(camera):
    assert camera.feature("TLParamsLocked").access is AccessMode.READ_ONLY
    with pytest.raises(FeatureAccessError, match="set by the stream alone"):
        camera.write_feature("TLParamsLocked", 1)
    camera.start()
    assert camera.feature("TLParamsLocked").value == 1
    camera.stop()
    assert camera.feature("TLParamsLocked").value == 0


def test_what_the_description_locks_only_while_it_streams_is_written_in_a_pause(camera, monkeypatch):
    monkeypatch.setattr(CameraNodeMap, "poll", lambda *of: None)  # reports values that change by themselves
    assert not camera.pauses_for("AcquisitionMode"), "nothing locks it yet"
    camera.start()
    changes = []
    camera.features_changed.connect(changes.append)
    pausing = {feature.name for feature in camera.features() if camera.pauses_for(feature.name)}
    assert {"AcquisitionMode", "PixelFormat", "Width", "BinningVertical"} <= pausing
    assert not pausing & {"HeightMax", "PayloadSize", "ExposureTime", "DeviceTemperature", "Gain"}
    assert camera.feature("TLParamsLocked").value == 1
    assert changes == [], "nobody hears of the question"
    camera.write_feature("ExposureTime", 1234.0)
    assert any("ExposureTime" in names for names in changes), "but of all that changes after it"
    assert camera.write_feature("AcquisitionMode", "MultiFrame").value == "MultiFrame"
    assert camera.streaming and camera.feature("TLParamsLocked").value == 1


def test_a_slider_costs_one_snapshot_and_one_register_a_step(camera, monkeypatch):
    """Each snapshot reads a dozen properties of a node: six of them took longer than the wire."""
    camera.write_feature("Gain", 1.0)
    snapshots, accesses = [], []
    snapshot, read, write = NodeFeature.snapshot, camera.device.read, camera.device.write
    monkeypatch.setattr(NodeFeature, "snapshot", lambda node: snapshots.append(node) or snapshot(node))
    monkeypatch.setattr(camera.device, "read", lambda *of: accesses.append("read") or read(*of))
    monkeypatch.setattr(camera.device, "write", lambda *of: accesses.append("write") or write(*of))

    assert camera.write_feature("Gain", 2.0).value == pytest.approx(2.0)
    assert len(snapshots) == 1
    assert accesses == ["write"]


def test_a_value_beyond_a_limit_that_moved_meanwhile_is_refused_with_the_limit_of_now(camera):
    """The limits that a write knows from the one before may be out of date."""
    before = camera.write_feature("OffsetX", 0).maximum
    camera.write_feature("Width", 128)
    now = before - 64

    with pytest.raises(FeatureValueError, match=rf"allowed: 0 … {now}\b"):
        camera.write_feature("OffsetX", before)
    assert camera.feature("OffsetX").value == 0
    assert camera.write_feature("OffsetX", now).value == now


def test_unknown_features_suggest_known_ones(camera):
    with pytest.raises(FeatureNotFoundError, match="did you mean ExposureTime"):
        camera.feature("ExposureTme")


def test_closing_ends_every_thread_and_may_be_done_twice():
    before = set(threading.enumerate())
    for _ in range(3):
        grabber = sources.create("sim:")
        assert isinstance(grabber, DeviceGrabber)
        grabber.open()
        queue = grabber.open_queue()
        grabber.start()
        queue.get(PATIENCE)
        grabber.close()
        grabber.close()
        assert queue.closed

    assert set(threading.enumerate()) == before
