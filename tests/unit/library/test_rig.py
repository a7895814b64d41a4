"""`grabbergui.open_rig`: sets of frames from several cameras, live and recorded."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import grabbergui
from grabbergui.library.rig import named_sources
from patience import PATIENCE

FAST = "sim:?width=64&height=48&fps=50&exposure=1000"
PAIR = {"left": f"{FAST}&serial=LEFT", "right": f"{FAST}&serial=RIGHT"}


@pytest.fixture
def rig() -> Iterator[grabbergui.Rig]:
    with grabbergui.open_rig(PAIR, trigger="software", rate=25, clock="fitted", Gain=2) as rig:
        yield rig


def test_sets_are_dicts_by_name(rig: grabbergui.Rig) -> None:
    whole = 0
    for images in rig.sets(10, timeout=PATIENCE):
        assert set(images) | set(images.missing) == {"left", "right"}
        if not images.missing:
            whole += 1
            assert images["left"].raw().shape == (48, 64) and 0 <= images.skew_ns < 20_000_000
    assert whole >= 7 and rig.statistics.complete >= 7
    assert rig["left"].gain == 2 and list(rig) == ["left", "right"] and len(rig) == 2
    assert not rig["left"].streaming
    assert rig.clocks["left"].kind == "fitted" and rig.clocks["left"].uncertainty_ns is not None
    with pytest.raises(grabbergui.UsageError, match="no camera top; there are left, right"):
        rig["top"]


def test_one_trigger_makes_one_set() -> None:
    with grabbergui.open_rig(PAIR, trigger="software") as rig:
        for _ in range(3):
            images = rig.trigger(PATIENCE)
            assert set(images) | set(images.missing) == {"left", "right"}
        assert rig["right"].streaming and rig.statistics.sets == 3
    with grabbergui.open(PAIR["left"]) as camera:
        assert camera.trigger_mode == "Off"


def test_a_recording_is_played_as_a_rig(rig: grabbergui.Rig, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    assert rig.record(path, sets=6).wait(PATIENCE).frames == 6
    with grabbergui.open_rig(path) as played:
        sets = list(played.sets(6, timeout=PATIENCE))
        assert [each.index for each in sets] == sorted(each.index for each in sets)
        assert {frozenset([*each, *each.missing]) for each in sets} == {frozenset(PAIR)}
        assert any(not each.missing and each.skew_ns for each in sets) and not played.cameras
        with pytest.raises(grabbergui.UsageError, match="a recording has no cameras"):
            played.trigger()
    with grabbergui.open(f"file:{path}?topic=/right/image_raw") as alone:
        assert alone.grab(PATIENCE).width == 64
    with pytest.raises(grabbergui.UsageError, match="into one file"):
        rig.record(tmp_path / "run.mp4")
    with pytest.raises(grabbergui.UsageError, match="is there already"):
        rig.record(path)


def test_a_name_that_is_wrong_is_refused_with_the_nearest(rig: grabbergui.Rig) -> None:
    with pytest.raises(AttributeError, match=r"no attribute exposure_tme; did you mean rig\['left'\]\.expos"):
        rig.exposure_tme = 3
    with pytest.raises(AttributeError, match=r"did you mean rig\['left'\]\.gain\?"):
        rig.gain = 3
    with pytest.raises(AttributeError, match=r"did you mean rig\.statistics\?"):
        _ = rig.statistic
    with pytest.raises(AttributeError, match="cameras of a rig cannot be set"):
        setattr(rig, "cameras", {})  # noqa: B010  type checkers refuse the assignment, too
    images = next(iter(rig.sets(timeout=PATIENCE)))
    with pytest.raises(grabbergui.MissingFrameError, match="no camera lft; did you mean left"):
        images["lft"]
    with pytest.raises(KeyError, match="there are left, right"):
        images["x"]


def test_a_closed_rig_says_so() -> None:
    rig = grabbergui.open_rig(PAIR, trigger="software")
    rig.close()
    calls = (rig.sets, rig.start, rig.trigger, lambda: rig.lead("left"), lambda: rig.record("run.mcap"))
    for call in calls:
        with pytest.raises(grabbergui.ClosedError, match="closed by this program"):
            call()
    assert rig.statistics.sets == 0
    rig.close()


def test_a_file_of_a_rig_is_opened(tmp_path: Path) -> None:
    path = tmp_path / "stereo.yaml"
    path.write_text(f'cameras: {{left: "{PAIR["left"]}", right: "{PAIR["right"]}"}}\nmissing: drop\n')
    with grabbergui.open_rig(path) as rig:
        assert [len(images) for images in rig.sets(3, timeout=PATIENCE)] == [2, 2, 2]


def test_no_set_says_why() -> None:
    with (
        grabbergui.open_rig(PAIR, trigger="software") as rig,  # but none is sent
        pytest.raises(grabbergui.FrameTimeoutError, match="waits for a trigger"),
    ):
        next(iter(rig.sets(timeout=0.1)))


def test_a_missing_frame_may_be_an_error() -> None:
    with grabbergui.open_rig(PAIR, trigger="software", missing="stop") as rig:
        loop = iter(rig.sets(timeout=PATIENCE))
        rig["left"].execute("TriggerSoftware")
        with pytest.raises(grabbergui.GrabberError, match="set 0 has no frame of right"):
            next(loop)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"trigger": "now"}, "trigger.by: 'now' is not allowed; write free or software or action or line"),
        ({"clock": "sun"}, "clock: 'sun' is not allowed"),
        ({"tolerance": -1.0}, "tolerance: -1.0 is not allowed; write a duration"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict, problem: str) -> None:
    with pytest.raises(grabbergui.UsageError) as refusal:
        grabbergui.open_rig(PAIR, **arguments)
    assert problem in str(refusal.value)


def test_cameras_are_named_as_in_their_sources_or_counted() -> None:
    assert named_sources(["gige:left", "gige:right"]) == {"left": "gige:left", "right": "gige:right"}
    assert list(named_sources(["gige:192.168.0.1", "gige:right"])) == ["camera1", "camera2"]
    assert list(named_sources(["sim:", "sim:"])) == ["camera1", "camera2"]
