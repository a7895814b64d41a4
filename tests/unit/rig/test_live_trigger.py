"""The trigger of one camera without a rig: which is on, its counts, and the cause of a problem."""

from dataclasses import replace

import pytest

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.grabber import Access, DeviceEvent
from grabbergui.core.settings import SettingKey
from grabbergui.rig import source
from grabbergui.rig.live_trigger import CameraTrigger, live_trigger
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from grabbergui.rig.trigger_setup import TriggerSetup, triggers_on
from patience import until

SMALL = "sim:?width=64&height=48&exposure=1000"
BURST = (("TriggerSelector", "FrameBurstStart"),)
FRAME = (("TriggerSelector", "FrameStart"),)
MISSED = SettingKey("EventNotification", (("EventSelector", "FrameTriggerMissed"),))


def problem(trigger):
    return trigger.report().findings.get("", "")


@pytest.fixture
def camera():
    grabber = sources.create(SMALL)
    grabber.open()
    yield grabber
    grabber.close()


def test_a_trigger_of_any_selector_is_found_and_the_one_that_is_waited_for_first_comes_first(camera):
    assert triggers_on(camera) == ()
    camera.write_setting(SettingKey("TriggerMode", FRAME), "On")
    frame = TriggerSetup("Software", "FrameStart", software=True)
    assert triggers_on(camera) == (frame,)
    camera.write_setting(SettingKey("TriggerSource", BURST), "Line1")
    camera.write_setting(SettingKey("TriggerActivation", BURST), "FallingEdge")
    camera.write_setting(SettingKey("TriggerMode", BURST), "On")
    before = camera.feature("TriggerSelector").value
    assert triggers_on(camera) == (TriggerSetup("Line1", "FrameBurstStart", "FallingEdge"), frame)
    assert camera.feature("TriggerSelector").value == before


def test_a_camera_with_one_trigger_or_a_selector_that_cannot_be_switched_has_its_selected_one():
    mode = Feature(name="TriggerMode", kind=FeatureKind.ENUMERATION, value="On", access=AccessMode.READ_ONLY)
    assert triggers_on(ScriptedGrabber([mode])) == (TriggerSetup(),)
    selector = replace(
        mode, name="TriggerSelector", value="FrameStart",
        entries=(EnumEntry("FrameBurstStart"), EnumEntry("FrameStart")),
    )  # fmt: skip
    grabber = ScriptedGrabber([replace(mode, selectors=("TriggerSelector",)), selector])
    assert triggers_on(grabber) == (TriggerSetup(selector="FrameStart"),)


def test_software_triggers_are_sent_and_counted_and_the_cameras_events_put_back(camera):
    camera.write_feature("TriggerMode", "On")
    trigger = live_trigger(camera, triggers_on(camera))
    assert trigger.sendable and camera.read_setting(MISSED).value == "On"
    camera.start(keep_trigger=True)
    trigger.send()
    until(lambda: trigger.report().counts.accepted == 1)
    counts = trigger.report().counts
    assert (counts.sent, counts.missed) == (1, 0)
    trigger.repeat(0.02)
    until(lambda: trigger.report().counts.accepted >= 4)
    assert trigger.repeating and not trigger.report().findings
    trigger.repeat(0)
    assert not trigger.repeating
    trigger.close()
    assert camera.read_setting(MISSED).value == "Off"


def test_triggers_that_come_too_fast_are_missed_and_explained(camera):
    camera.write_feature("ExposureTime", 200_000.0)
    camera.write_feature("TriggerMode", "On")
    trigger = live_trigger(camera, triggers_on(camera))
    camera.start(keep_trigger=True)
    trigger.repeat(0.04)
    until(lambda: "exposure and readout allow 5.0 Hz" in problem(trigger))
    assert trigger.report().counts.missed > 0
    trigger.close()


def test_a_line_without_a_signal_is_named_after_some_patience_and_a_wrong_edge_at_once(camera, monkeypatch):
    setup = TriggerSetup("Line1", "FrameStart", "RisingEdge")
    trigger = CameraTrigger(camera, [setup])
    assert not trigger.sendable and not trigger.report().findings, "too early"
    monkeypatch.setattr("grabbergui.rig.live_trigger.PATIENCE", 0.0)
    report = trigger.report()
    assert report.findings[""].startswith("there is no edge on Line1, it is always low")
    assert (report.counts.sent, report.counts.accepted, report.counts.missed) == (0, 0, 0)
    camera.event_received.emit(DeviceEvent("Line1FallingEdge", 1, {"EventLine1FallingEdgeTimestamp": 10**9}))
    assert "only edges of the other kind; set TriggerActivation to FallingEdge" in problem(trigger)
    trigger.close()


def test_without_control_nothing_is_sent_or_switched(camera):
    other = sources.create(SMALL)
    other.open(Access.MONITOR)
    trigger = CameraTrigger(other, [TriggerSetup("Software", "FrameStart", software=True)])
    assert not trigger.sendable
    trigger.close()
    other.close()


def test_a_rig_sends_and_counts_for_all_its_cameras():
    cameras = {name: CameraEntry(f"{SMALL}&serial={name}") for name in ("left", "right")}
    rig = source.of_entry(RigEntry(cameras, trigger=TriggerEntry("software")))
    rig.open()
    try:
        assert [each.source for each in triggers_on(rig)] == ["Software"]
        trigger = live_trigger(rig, triggers_on(rig))
        rig.start()
        trigger.repeat(0.03)
        until(lambda: trigger.report().counts.accepted >= 2)
        assert trigger.repeating and trigger.sendable
        trigger.repeat(0)
        counts = trigger.report().counts
        assert counts.sent is not None and counts.sent >= counts.accepted
        trigger.close()
    finally:
        rig.close()
