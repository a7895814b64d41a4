import pytest

from fakes import ScriptedGrabber
from grabbergui.core.errors import FeatureNotFoundError
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import DeviceEvent
from grabbergui.core.identity import DeviceInfo
from three_knobs import NAMES, ThreeKnobs


@pytest.fixture
def grabber():
    return ThreeKnobs(DeviceInfo("test:", vendor="Acme", model="Three"))


@pytest.mark.parametrize(
    ("asked", "hint"),
    [
        ("exposuretime", "did you mean ExposureTime"),
        ("ExposureTme", "did you mean ExposureTime"),
        ("gain", "did you mean Gain"),
    ],
)
def test_a_misspelt_feature_gets_a_suggestion(grabber, asked, hint):
    with pytest.raises(FeatureNotFoundError, match=f"^Acme Three has no feature {asked}; {hint}") as caught:
        grabber.feature(asked)
    assert caught.value.feature == asked


def test_a_completely_unknown_feature_gets_no_suggestion(grabber):
    with pytest.raises(FeatureNotFoundError, match=r"^Acme Three has no feature Zoom$"):
        grabber.feature("Zoom")


def test_features_are_in_the_trees_order(grabber):
    assert [feature.name for feature in grabber.features()] == list(NAMES)


def test_queues_end_with_the_grabber(grabber):
    queue = grabber.open_queue()
    grabber.close()
    assert queue.closed


@pytest.mark.parametrize(
    ("info", "title", "file_name"),
    [
        (DeviceInfo("sim:"), "sim:", "sim"),
        (DeviceInfo("sim:", "Acme", "One"), "Acme One", "One"),
        (DeviceInfo("sim:", "Acme", "One", "7", user_name="left eye"), "left eye", "left-eye"),
        (DeviceInfo("sim:", "Acme", "One", "7", address="10.0.0.7"), "Acme One 7", "One_7"),
        (DeviceInfo("sim:", "Acme", "One", address="10.0.0.7"), "Acme One 10.0.0.7", "One_10.0.0.7"),
        (DeviceInfo("sim:", model="/camera", address="/camera"), "/camera", "camera"),
    ],
)
def test_the_names_of_a_source_distinguish_it_from_others_of_its_model(info, title, file_name):
    assert (info.title, info.short_title) == (title, title.removeprefix("Acme "))
    assert info.file_name == file_name
    assert info.as_dict()["uri"] == "sim:"


def test_statistics_are_a_dictionary_for_json():
    assert StreamStatistics(frames=3).as_dict()["frames"] == 3


def test_a_source_that_says_nothing_else_never_pauses():
    assert ScriptedGrabber().pauses_for("Width") is False


def test_an_event_is_shown_with_its_values():
    assert str(DeviceEvent("ExposureEnd", 1, {})) == "ExposureEnd"
    assert str(DeviceEvent("ExposureEnd", 1, {"A": 1, "B": "x"})) == "ExposureEnd: A=1, B=x"
