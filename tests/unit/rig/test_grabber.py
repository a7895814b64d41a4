"""A rig of simulated cameras as a source."""

import pytest

from grabbergui import sources
from grabbergui.core.errors import FeatureAccessError, FeatureNotFoundError, UsageError
from grabbergui.core.features import FeatureKind
from grabbergui.core.grabber import DeviceEvent
from grabbergui.core.settings import SettingKey
from grabbergui.rig import rig_file, source
from grabbergui.rig.rig_file import CameraEntry, FollowEntry, RigEntry, TriggerEntry
from grabbergui.rig.set_frame import SetFrame
from patience import PATIENCE, until

FAST = "sim:?width=64&height=48&fps=50&exposure=1000"


def entry(*names, settings=None, **more):
    return RigEntry({name: CameraEntry(f"{FAST}&serial={name}", settings or {}) for name in names}, **more)


@pytest.fixture
def opened():
    rigs = []

    def open_rig(content):
        rig = source.of_entry(content)
        rigs.append(rig)
        rig.open()
        return rig

    yield open_rig
    for rig in rigs:
        rig.close()


def frames_of(rig, count):
    queue = rig.open_queue(16)
    rig.start()
    return [queue.get(PATIENCE) for _ in range(count)]


@pytest.mark.parametrize("clock", ["fitted", "host", "auto"])
def test_triggered_cameras_make_sets(opened, clock):
    rig = opened(entry("left", "right", "top", clock=clock, trigger=TriggerEntry("software", 25)))
    queue, sets, whole = rig.open_queue(500), [], []
    rig.start()
    # By times of arrival a busy machine makes fewer of them.
    while len(whole) < 8 or rig.counts().complete < 8:
        sets.append(queue.get(PATIENCE))
        assert isinstance(sets[-1], SetFrame) and len(sets) < 500
        if not sets[-1].images.missing:
            whole.append(sets[-1])
    for each in whole:
        assert list(each.images) == ["left", "right", "top"]
        assert [part.name for part in each.parts] == ["left", "right", "top"]
        assert [part.source for part in each.parts] == [0, 1, 2]
        assert each.images.skew_ns < 20_000_000 and abs(each.captured * 1e9 - each.images.time_ns) < 1000
        assert {member.received_ns for member in each.members().values()} == {each.received_ns}
        assert list(each.detached().members()) == ["left", "right", "top"]
    assert [each.frame_id for each in sets] == sorted({each.frame_id for each in sets})
    counts = rig.counts()
    assert 0 <= counts.skew_median_ns <= counts.skew_worst_ns
    assert {state.kind for state in rig.clock_states().values()} == {
        {"fitted": "fitted", "host": "host", "auto": "ptp"}[clock]
    }


def test_a_trigger_is_sent_on_request_and_settings_come_back(opened):
    rig = opened(entry("left", "right", trigger=TriggerEntry("software"), settings={"Gain": 3}))
    camera = rig.cameras["left"]
    queue = rig.open_queue(4)
    rig.start()
    assert camera.feature("Gain").value == 3 and camera.feature("TriggerMode").value == "On"
    assert camera.feature("PtpEnable").value is True
    seen, sent = set(), 0
    # A busy machine may trigger the cameras one long after the other: their images are then no set.
    while seen != {"left", "right"} and sent < 50:
        rig.execute("RigTriggerSend")
        sent += 1
        seen = set(queue.get(PATIENCE).images)
    assert seen == {"left", "right"}
    assert rig.feature("RigTriggersSent").value == sent
    rig._trigger.undo()
    rig._settings.undo()
    assert camera.feature("Gain").value == 0 and camera.feature("TriggerMode").value == "Off"
    assert camera.feature("PtpEnable").value is False


def test_middles_and_ends_of_exposures_are_aligned_by_delays(opened):
    content = entry("left", "right", trigger=TriggerEntry("software", align="middle"))
    rig = opened(content)
    rig.cameras["right"].write_feature("ExposureTime", 5000)
    rig.start()
    delays = [
        camera.read_setting(SettingKey("TriggerDelay", (("TriggerSelector", "FrameStart"),))).value
        for camera in rig.cameras.values()
    ]
    assert delays == [2000, 0]


def test_features_are_those_of_the_cameras_and_of_the_rig(opened):
    rig = opened(entry("left", "right"))
    rig.write_feature("left.ExposureTime", 2000)
    assert (rig.feature("left.ExposureTime").value, rig.feature("right.ExposureTime").value) == (2000, 1000)
    key = SettingKey.parse("right.TriggerDelay[right.TriggerSelector=FrameBurstStart]")
    rig.write_setting(key, 500)
    assert rig.read_setting(key).value == 500
    names = {description.name for description in rig.feature_tree().descriptions()}
    assert {"left.Gain", "right.Gain", "RigSkewMedian"} <= names
    assert not rig.has_feature("RigTriggerSend") and rig.feature("RigSkewMedian").kind is FeatureKind.FLOAT
    with pytest.raises(FeatureNotFoundError, match=r"did you mean left\.Gain"):
        rig.feature("left_Gain")
    with pytest.raises(FeatureAccessError):
        rig.write_feature("RigSetsComplete", 3)


def test_the_others_follow_the_leader_within_their_limits(opened):
    follow = FollowEntry("left", ("ExposureTime", "Gain"), {"right": 2.0}, {"right": (10, 5000)})
    rig = opened(entry("left", "right", "top", follow=follow))
    rig.start()
    rig.cameras["left"].write_feature("ExposureTime", 4000)
    rig.cameras["left"].write_feature("Gain", 6)
    value = lambda name, feature: rig.cameras[name].feature(feature).value  # noqa: E731
    until(lambda: (value("right", "ExposureTime"), value("top", "ExposureTime")) == (5000, 4000))
    until(lambda: value("top", "Gain") == value("right", "Gain") == 6)
    rig.lead("top")
    rig.cameras["top"].write_feature("Gain", 2)
    until(lambda: value("left", "Gain") == value("right", "Gain") == 2)
    with pytest.raises(UsageError, match="no camera middle"):
        rig.lead("middle")
    assert rig.leader == "top"


def test_followers_are_chosen_while_live_in_a_rig_whose_file_names_none(opened):
    rig = opened(entry("left", "right"))
    rig.start()
    assert rig.leader == ""
    rig.lead("right")
    rig.cameras["right"].write_feature("Gain", 3)
    until(lambda: rig.cameras["left"].feature("Gain").value == 3)
    rig.lead("")
    assert rig.leader == ""


def test_events_of_the_cameras_have_their_names(opened):
    rig, seen = opened(entry("left", "right")), []
    rig.event_received.connect(seen.append)
    rig.cameras["right"].event_received.emit(DeviceEvent("ExposureEnd", 7, {"EventExposureEndFrameID": 5}))
    assert seen == [DeviceEvent("right.ExposureEnd", 7, {"EventExposureEndFrameID": 5})]


def test_a_rig_is_a_source_like_any_other(tmp_path):
    path = tmp_path / "stereo.yaml"
    rig_file.write(path, entry("left", "right"))
    rig = sources.create(f"rig:{path}")
    rig.open()
    try:
        assert rig.info.title == "stereo" and rig.streaming is False
        (frame,) = frames_of(rig, 1)
        assert frame.rgb().shape == (48, 64, 3)
        until(lambda: rig.statistics().frames >= 2)
        rig.stop()
        assert not any(camera.streaming for camera in rig.cameras.values())
        frames_of(rig, 1)  # it starts again
    finally:
        rig.close()


def test_actions_need_gige_cameras(opened):
    rig = opened(entry("left", trigger=TriggerEntry("action")))
    with pytest.raises(UsageError, match=r"left .* is not a GigE Vision camera, so it has no actions"):
        rig.start()
    assert not rig.streaming and rig.cameras["left"].feature("TriggerMode").value == "Off"
