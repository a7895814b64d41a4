"""Further handles on an open grabber: one that passes everything on, and one that writes nothing."""

import threading

import pytest

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, FeatureAccessError, FeatureNotFoundError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import AccessMode, FeatureKind
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.register_source import RegisterSource
from grabbergui.core.settings import SettingKey
from grabbergui.core.shared import ReadOnlyGrabber, SharedGrabber
from grabbergui.core.stream_source import StreamSource
from grabbergui.net.tree import TreeService
from patience import PATIENCE
from three_knobs import ThreeKnobs


class Plain(ThreeKnobs):
    """Looks at no queue that it gave away."""

    def open_queue(self, depth=2):
        return FrameQueue(depth)


def test_every_call_is_passed_on_to_the_shared_grabber():
    public = {
        name
        for base in (FrameGrabber, RegisterSource, FeatureSource, StreamSource)
        for name, kind in vars(base).items()
        if not name.startswith("_") and (callable(kind) or isinstance(kind, property))
    }
    made_of_the_others = {"features", "role"}

    assert public - made_of_the_others <= set(vars(SharedGrabber))


def test_no_queue_is_lost_if_two_threads_open_one_at_the_same_time():
    handle, opened = SharedGrabber(Plain(DeviceInfo("test:"))), []
    other = threading.Thread(target=lambda: opened.append(handle.open_queue()))

    class Meddling(FrameQueue):
        """Another thread opens a queue while the list of queues is rebuilt."""

        @property
        def closed(self):
            if other.ident is None:
                other.start()
                other.join(0.2)  # held off until the list is made, or done by now
            return super().closed

    opened.append(handle.open_queue())
    opened[0].__class__ = Meddling
    opened.append(handle.open_queue())
    other.join(PATIENCE)
    handle.close()
    assert len(opened) == 3 and all(queue.closed for queue in opened)


@pytest.fixture
def both():
    camera = sources.create("sim:?width=64&height=48&fps=100&pixel_format=BayerRG8")
    camera.open()
    shown = ReadOnlyGrabber(camera)
    shown.open()
    yield camera, shown
    shown.close()
    camera.close()


def test_a_readonly_grabber_writes_and_runs_no_feature(both):
    camera, shown = both
    assert shown.access is Access.MONITOR
    for feature in camera.features():
        assert not shown.feature(feature.name).access.writable
        assert shown.read_features([feature.name]) == [shown.feature(feature.name)]
        refused = shown.execute if feature.kind is FeatureKind.COMMAND else None
        with pytest.raises(FeatureAccessError, match=f"{feature.name} cannot be .*read-only"):
            refused(feature.name) if refused else shown.write_feature(feature.name, feature.value)
    with pytest.raises(FeatureNotFoundError):
        shown.write_feature("NoSuch", 1)


def test_settings_under_selectors_are_read_only_too(both):
    camera, shown = both
    red, blue = (
        SettingKey.parse(f"BalanceRatio[BalanceRatioSelector={colour}]") for colour in ("Red", "Blue")
    )
    camera.write_feature("BalanceRatioSelector", "Red")
    before = camera.read_setting(blue).value
    assert shown.read_setting(red).value == camera.read_setting(red).value
    for refused in (
        lambda: shown.read_setting(blue),
        lambda: shown.write_setting(red, 2.0),
        lambda: shown.write_setting(blue, 2.0),
        lambda: shown.write_setting(SettingKey("Gain"), 2.0),
        lambda: shown.execute_setting(SettingKey.parse("UserSetSave[UserSetSelector=UserSet1]")),
        lambda: TreeService(shown).perform("set", "Gain", "2"),
        lambda: TreeService(shown).perform("write", "Gain", "2"),
        lambda: TreeService(shown).perform("execute", "UserSetSave"),
    ):
        with pytest.raises(FeatureAccessError, match="read-only"):
            refused()
    assert camera.feature("BalanceRatioSelector").value == "Red"
    assert camera.read_setting(blue).value == before


READS = {
    "calibration", "close", "conditions", "exclusive", "feature_tree", "features", "has_feature", "lost",
    "open", "open_queue", "read_features", "read_register", "reads_at_once", "recorded_coordinates",
    "register_length", "role", "selectors", "setting", "silence", "statistics", "streaming",
}  # fmt: skip
"""Passed on as they are: none of them writes to the camera, or it does so by a method that is refused."""


def test_whether_a_method_writes_was_decided_for_each():
    signals = {
        "features_changed",
        "connection_changed",
        "noticed",
        "event_received",
        "held_changed",
        "shared",
        "unlike_before",
        "changed_meanwhile",
    }
    bases = (FrameGrabber, RegisterSource, FeatureSource, StreamSource)
    methods = {name for base in bases for name in vars(base) if not name.startswith("_")} - signals
    undecided = methods - READS - set(vars(ReadOnlyGrabber))
    assert not undecided, "a new method of FrameGrabber: refuse it in ReadOnlyGrabber, or add it to READS"


def test_a_readonly_grabber_delivers_values_and_frames_and_cannot_stop_the_stream(both):
    camera, shown = both
    with pytest.raises(AccessDeniedError, match="cannot be started"):
        shown.start()
    camera.start()
    shown.start()
    assert shown.open_queue(1).get(PATIENCE).width == 64
    with pytest.raises(AccessDeniedError, match="cannot be stopped"):
        shown.stop()
    assert camera.streaming
    camera.write_feature("Gain", 3.0)
    assert shown.feature("Gain").value == 3.0


def test_a_readonly_grabber_offers_no_feature_that_only_the_stream_locks(both):
    camera, shown = both
    camera.start()
    assert camera.offered(camera.feature("Width")).access is AccessMode.READ_WRITE
    assert shown.offered(shown.feature("Width")).access is AccessMode.READ_ONLY
