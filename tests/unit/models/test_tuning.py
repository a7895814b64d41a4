"""Faults during a tuning run: everything is restored, or the message says what is not."""

import threading

import pytest

from grabbergui.core.errors import DeviceLostError, FeatureError, FrameTimeoutError
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.core.frame_period import FRAME_WAIT
from grabbergui.core.sfnc import Role
from grabbergui.models import tuning
from grabbergui.models.one_push import EXPOSURE_STEPS, expose, let_camera
from grabbergui.models.undo_steps import Direction, UndoStep
from patience import PATIENCE
from tuning_stage import REGION, on


def test_no_frames_is_a_failure_that_says_what_to_do(stage, monkeypatch):
    monkeypatch.setattr(tuning, "SILENT", 0.2)
    s = stage()
    s.grabber.sending.clear()
    s.run(on(REGION, expose))
    assert "start the camera" in s.failures[0]


@pytest.fixture
def run(stage):
    s = stage()
    run = tuning.TuningRun(s.tracked_grabber, s.features, UndoStep("Exposure"), lambda *_: None)
    run.grabber = s.grabber
    yield run
    run.close()


def test_a_frame_may_take_as_long_as_the_camera_exposes_now_or_did_before(run):
    run.grabber.set("ExposureTimeRaw", 8_000_000)
    assert run.patience() == tuning.SILENT + 2 * 8
    run.grabber.set("ExposureTimeRaw", 1000)
    assert run.patience() == tuning.SILENT + 2 * 8
    assert run.patience() == pytest.approx(tuning.SILENT + 2 / 30)


def test_a_trigger_may_take_longer_than_the_frames_of_a_camera_that_runs_free(run):
    run.grabber.known["TriggerMode"] = Feature(
        name="TriggerMode", kind=FeatureKind.ENUMERATION, value="On", access=AccessMode.READ_WRITE
    )
    assert run.patience() == pytest.approx(FRAME_WAIT + 2 / 30)


def test_the_cameras_own_mode_ends_early_without_frames(stage_on_sim, monkeypatch):
    monkeypatch.setattr(tuning, "SILENT", 0.2)
    s = stage_on_sim("pixel_format=RGB8&exposure=100")
    s.grabber.stop()
    s.run(lambda bench: let_camera(bench, Role.EXPOSURE))
    assert "start the camera" in s.failures[0]


def test_a_refusal_on_the_way_restores_everything(stage):
    s = stage(light=0.01)
    s.grabber.refusals["GainRaw"] = FeatureError("GainRaw=9: the camera answered: busy", "GainRaw")
    s.run(on(REGION, expose))
    assert s.failures == ["Exposure: GainRaw=9: the camera answered: busy"]
    assert s.value("ExposureTimeRaw") == 1000
    assert s.journal.next_text(Direction.UNDO) == ""


def test_values_that_were_not_restored_are_reported(stage):
    s = stage(light=0.01)

    def refuse(name, value):
        if name == "GainRaw":
            s.grabber.refusals["ExposureTimeRaw"] = FeatureError("ExposureTimeRaw is locked", "")
            raise DeviceLostError("the camera is gone")
        return value

    s.grabber.on_write = refuse
    s.run(on(REGION, expose))
    assert s.failures == [
        "Exposure: the camera is gone; not everything could be restored: ExposureTimeRaw is locked"
    ]


def test_cancelling_restores_everything(stage):
    s = stage(light=0.01)
    s.push.progressed.connect(lambda share, text: s.push.cancel() if share > 0.1 else None)
    s.run(on(REGION, expose))
    assert s.failures == ["Exposure: cancelled"]
    assert (s.value("ExposureTimeRaw"), s.value("GainRaw")) == (1000, 0)


def test_a_scene_that_never_settles_ends_within_its_bounds_and_restores(stage):
    s = stage()
    s.push.progressed.connect(lambda *_: setattr(s.grabber, "light", 30.0 if s.grabber.light < 1 else 0.03))
    s.run(on(REGION, expose))
    assert "did not settle" in s.failures[0]
    assert len(s.progress) == EXPOSURE_STEPS
    assert s.value("ExposureTimeRaw") == 1000


def test_only_one_at_a_time(stage):
    s = stage()
    entered, leave = threading.Event(), threading.Event()

    def slow(bench):
        entered.set()
        assert leave.wait(PATIENCE)
        return "done"

    assert s.push.start("Slow", slow, s.tracked_grabber, s.features)
    assert entered.wait(PATIENCE) and s.push.running
    assert not s.push.start("Other", slow, s.tracked_grabber, s.features)
    leave.set()
    assert s.push.wait(PATIENCE) and not s.push.running
    assert s.results == ["done"]


def test_closing_the_camera_ends_it(stage):
    s = stage(light=0.01)
    closed = threading.Event()

    def close(*_):
        s.worker.close(0)
        closed.set()

    s.push.progressed.connect(close)
    s.run(on(REGION, expose))
    assert closed.is_set() and "closed" in s.failures[0]


def test_no_frame_error_is_a_grabbers(stage):
    s = stage()
    s.grabber.sending.clear()
    bench = tuning.TuningRun(s.tracked_grabber, s.features, None, lambda *_: None)
    bench.close()
    with pytest.raises(FrameTimeoutError):
        bench.light(None)


def test_the_operators_last_writes_precede_a_tuning(stage):
    s = stage()
    s.features.write("GainRaw", 10)
    s.features.write("GainRaw", 480)  # held back, as it came so soon after the first
    seen = []

    def look(bench):
        seen.append(bench.call(lambda grabber: grabber.feature("GainRaw").value))
        return "looked"

    assert s.run(look) == "looked"
    assert seen == [480]
