"""One-push exposure and white balance, on the simulated camera and on a made-up one without any automatic."""

import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core import pfnc
from grabbergui.core.errors import DeviceLostError, FeatureError, FrameTimeoutError
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.frame import Frame
from grabbergui.core.region import Region
from grabbergui.core.sfnc import Role
from grabbergui.models.changes.journal import ChangeJournal
from grabbergui.models.changes.noting import NotingGrabber
from grabbergui.models.changes.reverting import revert
from grabbergui.models.changes.undo_history import Direction
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.models.tuning import bench as bench_module
from grabbergui.models.tuning.camera_once import has_once, let_camera
from grabbergui.models.tuning.exposure import MOST_TURNS, TOLERANCE, expose
from grabbergui.models.tuning.knob_search import KnobSearch, Law, light_factor
from grabbergui.models.tuning.light import measure
from grabbergui.models.tuning.one_push import OnePush
from grabbergui.models.tuning.white_balance import balance

REGION = Region(100, 80, 120, 100)


# -- the light of a region ---------------------------------------------------------------------------
def frame_of(pixels, name):
    pixels = np.ascontiguousarray(pixels)
    payload = pixels.reshape(-1).view(np.uint8)
    return Frame(payload, pixels.shape[1], pixels.shape[0], pfnc.by_name(name))


@pytest.mark.parametrize(("name", "dtype", "white"), [("Mono8", np.uint8, 255), ("Mono12", np.uint16, 4095)])
def test_light_is_measured_in_the_region_alone(name, dtype, white):
    pixels = np.zeros((40, 60), dtype)
    pixels[10:20, 20:40] = white // 2
    pixels[10:15, 20:40] = white
    light = measure(frame_of(pixels, name), Region(20, 10, 20, 10))
    assert light.mean == pytest.approx(0.75, abs=0.01)
    assert light.saturated == 0.5
    assert not light.coloured
    assert measure(frame_of(pixels, name)).mean == pytest.approx(0.75 * 200 / 2400, abs=0.01)


@pytest.mark.parametrize("order", ["RG", "GR", "GB", "BG"])
def test_the_colours_of_a_mosaic_are_told_apart_wherever_the_region_begins(order):
    planes = {"R": 200, "G": 100, "B": 50}
    second = {"RG": "GB", "BG": "GR", "GR": "BG", "GB": "RG"}[order]
    pixels = np.empty((20, 20), np.uint8)
    for line, colours in enumerate((order, second)):
        for column, name in enumerate(colours):
            pixels[line::2, column::2] = planes[name]
    for region in (Region(0, 0, 20, 20), Region(7, 5, 4, 6), Region(19, 19, 1, 1)):
        light = measure(frame_of(pixels, f"Bayer{order}8"), region)
        assert {name: round(mean * 255) for name, mean in light.channels.items()} == planes


# -- the search --------------------------------------------------------------------------------------
@given(
    truth=st.floats(0.01, 1e4),
    start=st.floats(1, 1e6),
    gamma=st.floats(0.4, 1.6),
    black=st.floats(0, 0.1),
    target=st.floats(0.2, 0.8),
)
def test_a_proportional_knob_gets_there_through_gamma_black_level_and_saturation(
    truth, start, gamma, black, target
):
    def seen(value):
        light = (value / 1e4 * truth) ** gamma
        return min(1.0, black + light), float(black + light >= 1)

    search = KnobSearch(start, 1.0, 1e6, Law.PROPORTIONAL)
    for _ in range(60):
        mean, saturated = seen(search.value)
        if abs(mean - target) <= 0.02:
            return
        if search.propose(light_factor(mean, saturated, target)) is None:
            # The end of the range: nothing beyond it would have been allowed.
            assert search.value in (1.0, 1e6)
            return
    pytest.fail(f"stands at {search.value} with {seen(search.value)}")


@given(start=st.floats(0, 48), wanted=st.floats(0, 48), law=st.sampled_from([Law.DECIBEL, Law.UNKNOWN]))
def test_a_gain_gets_there_whatever_its_law(start, wanted, law):
    search = KnobSearch(start, 0.0, 48.0, law)
    for _ in range(40):
        ratio = 10 ** ((wanted - search.value) / 20)
        if abs(ratio - 1) < 0.02 or search.propose(ratio) is None:
            break
    assert search.value == pytest.approx(wanted, abs=0.2)


def test_bounds_that_the_scene_has_outlived_are_forgotten():
    search = KnobSearch(100.0, 1.0, 1e6, Law.PROPORTIONAL)
    search.propose(2.0)
    search.propose(0.5)
    for _ in range(60):
        search.propose(1.5)
    assert search.value > 1000


# -- a camera without any automatic ------------------------------------------------------------------
class PlainCamera(ScriptedGrabber):
    """Makes frames by what its features say, some frames late; a grey scene under a coloured lamp."""

    LATE = 3

    def __init__(self, *, lamp=(0.5, 1.0, 0.7), light=1.0, pixel_format="RGB8", gain=True, rate=30.0):
        def number(name, value, low, high, **more):
            more = {"access": AccessMode.READ_WRITE, "minimum": low, "maximum": high, **more}
            return Feature(name=name, kind=more.pop("kind", FeatureKind.FLOAT), value=value, **more)

        features = [
            number("ExposureTimeRaw", 1000, 20, 1_000_000, kind=FeatureKind.INTEGER, unit="us", increment=20),
            number("AcquisitionFrameRate", rate, 1.0, 100.0, unit="Hz"),
            Feature(
                name="BalanceRatioSelector", kind=FeatureKind.ENUMERATION, value="Green",
                entries=tuple(EnumEntry(n) for n in ("Red", "Green", "Blue")), access=AccessMode.READ_WRITE,
            ),
            number("BalanceRatio", 1.0, 0.25, 4.0, selectors=("BalanceRatioSelector",)),
        ]  # fmt: skip
        if gain:
            features.append(number("GainRaw", 0, 0, 480, kind=FeatureKind.INTEGER))
        super().__init__(features)
        self.lamp, self.light, self.pixel_format = lamp, light, pixel_format
        self.ratios = {"Red": 1.0, "Green": 1.0, "Blue": 1.0}
        self.past = []
        self.sending = threading.Event()
        self.sending.set()
        self._ended = threading.Event()
        self._sender = threading.Thread(target=self._send)
        self._sender.start()

    def write_feature(self, name, value):
        feature = super().write_feature(name, value)
        if name == "BalanceRatioSelector":
            self.known["BalanceRatio"] = self._with_value("BalanceRatio", self.ratios[value])
        elif name == "BalanceRatio":
            self.ratios[self.known["BalanceRatioSelector"].value] = feature.value
        return feature

    def _with_value(self, name, value):
        known = self.known[name]
        return Feature(**{**vars(known), "value": value})

    def close(self):
        self._ended.set()
        self._sender.join()
        super().close()

    def _send(self):
        while not self._ended.wait(0.002):
            gain = 10 ** (self.known["GainRaw"].value / 10 / 20) if "GainRaw" in self.known else 1
            light = self.known["ExposureTimeRaw"].value / 10_000 * gain * self.light
            ratios = self.ratios.values()
            colour = [light * part * ratio for part, ratio in zip(self.lamp, ratios, strict=True)]
            self.past = [*self.past, colour][-self.LATE :]
            if self.sending.is_set():
                self._fanout.put(self._frame(self.past[0]))

    def _frame(self, colour):
        if self.pixel_format == "Mono8":
            pixels = np.full((200, 300), min(255, round(255 * 0.5 * colour[1])), np.uint8)
        else:
            values = [min(255, round(255 * 0.5 * part)) for part in colour]
            pixels = np.broadcast_to(np.array(values, np.uint8), (200, 300, 3))
        return frame_of(pixels, self.pixel_format)


class Stage:
    """A camera, the hands on it, and a tuning."""

    def __init__(self, grabber):
        self.grabber = grabber
        self.worker = FeatureWorker()
        self.journal = ChangeJournal()
        self.hands = NotingGrabber(grabber, self.journal)
        self.hands.open()
        self.push = OnePush()
        self.said, self.results, self.failures = [], [], []
        self.push.progressed.connect(lambda share, text: self.said.append((share, text)))
        self.push.succeeded.connect(self.results.append)
        self.push.failed.connect(self.failures.append)

    def run(self, tuning, name="Exposure"):
        assert self.push.start(name, tuning, self.hands, self.worker)
        assert self.push.wait(30)
        return self.results[-1] if self.results else ""

    def value(self, name):
        return self.grabber.feature(name).value

    def light(self, region=REGION):
        queue = self.grabber.open_queue()
        try:
            for _ in range(5):
                frame = queue.get(5)
            return measure(frame, region)
        finally:
            queue.close()

    def close(self):
        self.push.cancel()
        assert self.push.wait(10)
        self.hands.close()
        assert self.worker.close()
        self.grabber.close()


@pytest.fixture
def stage():
    stages = []

    def build(grabber=None, **how):
        stages.append(Stage(grabber or PlainCamera(**how)))
        return stages[-1]

    yield build
    for made in stages:
        made.close()


@pytest.fixture
def sim(stage):
    def build(options="pixel_format=RGB8"):
        camera = sources.create(f"sim:?width=320&height=240&fps=60&{options}")
        camera.open()
        camera.start()
        return stage(camera)

    return build


def on(region, tuning):
    return lambda bench: tuning(bench, region)


@pytest.mark.parametrize("light", [0.02, 0.3, 1.0, 40.0])
def test_exposure_finds_the_target_without_any_automatic(stage, light):
    s = stage(light=light)
    assert "Exposed" in s.run(on(REGION, expose)), s.failures
    assert s.light().mean == pytest.approx(0.5, abs=TOLERANCE)
    assert 0.0 <= s.said[0][0] <= s.said[-1][0] < 1.0
    assert len(s.said) <= MOST_TURNS


def test_the_time_grows_up_to_the_frame_rates_room_and_gain_does_the_rest(stage):
    s = stage(light=0.1, rate=50.0)
    assert "Exposed" in s.run(on(REGION, expose)), s.failures
    assert s.value("ExposureTimeRaw") == 20_000
    assert 60 < s.value("GainRaw") < 300
    s.grabber.light = 2.0
    assert "Exposed" in s.run(on(REGION, expose)), s.failures
    assert s.value("GainRaw") == 0, "gain is lowered before the time is shortened"


def test_what_cannot_be_reached_is_said_and_the_nearest_is_kept(stage):
    s = stage(light=0.001, gain=False)
    assert "As bright as it gets" in s.run(on(REGION, expose))
    assert s.value("ExposureTimeRaw") == 33_320
    s = stage(light=5000.0)
    assert "As dark as it gets" in s.run(on(REGION, expose))
    assert s.value("ExposureTimeRaw") == 20


def test_all_that_was_tuned_is_undone_in_one_step(stage):
    s = stage(light=0.1)
    s.run(on(REGION, expose), name="Exposure on a region")
    assert s.journal.next_text(Direction.UNDO) == "Exposure on a region"
    assert revert(s.hands, Direction.UNDO) == []
    assert (s.value("ExposureTimeRaw"), s.value("GainRaw")) == (1000, 0)
    assert s.journal.next_text(Direction.UNDO) == ""


def test_white_balance_makes_grey_grey_without_any_automatic(stage):
    s = stage()
    s.run(on(REGION, expose))
    assert "Balanced" in s.run(on(REGION, balance), name="White balance"), s.failures
    light = s.light().channels
    assert light["R"] == pytest.approx(light["G"], rel=0.02)
    assert light["B"] == pytest.approx(light["G"], rel=0.02)
    ratios = s.grabber.ratios
    assert (ratios["Red"], ratios["Blue"]) == (pytest.approx(2.0, rel=0.03), pytest.approx(1 / 0.7, rel=0.03))
    assert ratios["Green"] == 1.0
    assert s.value("BalanceRatioSelector") == "Green"
    assert revert(s.hands, Direction.UNDO) == []
    assert s.grabber.ratios == {"Red": 1.0, "Green": 1.0, "Blue": 1.0}


def test_a_lamp_beyond_the_ratios_is_said(stage):
    s = stage(lamp=(0.1, 1.0, 1.0))
    s.run(on(REGION, expose))
    assert "As grey as it gets" in s.run(on(REGION, balance))
    assert s.grabber.ratios["Red"] == 4.0


@pytest.mark.parametrize(
    ("how", "said"),
    [({"pixel_format": "Mono8"}, "no colour"), ({"light": 50.0}, "saturated"), ({"light": 0.1}, "too dark")],
)
def test_white_balance_says_what_hinders_it_and_changes_nothing(stage, how, said):
    s = stage(**how)
    s.run(on(REGION, balance), name="White balance")
    assert said in s.failures[0]
    assert [name for name, _, _ in s.grabber.writes if name == "BalanceRatio"] == []


# -- going wrong -------------------------------------------------------------------------------------
def test_no_frames_is_a_failure_that_says_what_to_do(stage, monkeypatch):
    monkeypatch.setattr(bench_module, "FRAME_PATIENCE", 0.2)
    s = stage()
    s.grabber.sending.clear()
    s.run(on(REGION, expose))
    assert "start the camera" in s.failures[0]


def test_a_refusal_on_the_way_restores_everything(stage):
    s = stage(light=0.01)
    s.grabber.refusals["GainRaw"] = FeatureError("GainRaw=9: the camera answered: busy", "GainRaw")
    s.run(on(REGION, expose))
    assert s.failures == ["Exposure: GainRaw=9: the camera answered: busy"]
    assert s.value("ExposureTimeRaw") == 1000
    assert s.journal.next_text(Direction.UNDO) == ""


def test_what_could_not_be_restored_is_said(stage):
    s = stage(light=0.01)

    def refuse(name, value):
        if name == "GainRaw":
            s.grabber.refusals["ExposureTimeRaw"] = FeatureError("ExposureTimeRaw is locked", "")
            raise DeviceLostError("the camera is gone")
        return value

    s.grabber.on_write = refuse
    s.run(on(REGION, expose))
    assert s.failures == ["Exposure: the camera is gone; not all is as it was: ExposureTimeRaw is locked"]


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
    assert len(s.said) == MOST_TURNS
    assert s.value("ExposureTimeRaw") == 1000


def test_only_one_at_a_time(stage):
    s = stage()
    entered, leave = threading.Event(), threading.Event()

    def slow(bench):
        entered.set()
        assert leave.wait(5)
        return "done"

    assert s.push.start("Slow", slow, s.hands, s.worker)
    assert entered.wait(5) and s.push.running
    assert not s.push.start("Other", slow, s.hands, s.worker)
    leave.set()
    assert s.push.wait(5) and not s.push.running
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


# -- the simulated camera ----------------------------------------------------------------------------
@pytest.mark.parametrize(
    "options", ["pixel_format=Mono8", "pixel_format=BayerRG12p&exposure=50", "exposure=45000&fps=20"]
)
def test_exposure_on_a_region_of_the_simulated_camera(sim, options):
    s = sim(options)
    s.grabber.write_feature("Gamma", 0.8)
    s.grabber.write_feature("ExposureAuto", "Continuous")
    begun = time.monotonic()
    assert "Exposed" in s.run(on(REGION, expose)), s.failures
    # The scene wanders, so a little more than the tolerance is allowed.
    assert s.light().mean == pytest.approx(0.5, abs=2 * TOLERANCE)
    assert s.value("ExposureAuto") == "Off"
    assert time.monotonic() - begun < 20


@pytest.mark.parametrize("options", ["pixel_format=RGB8", "pixel_format=BayerGB8", "pixel_format=BayerRG12p"])
def test_white_balance_on_a_region_of_the_simulated_camera(sim, options):
    s = sim(options)
    for selected in ("Red", "Blue"):
        s.grabber.write_feature("BalanceRatioSelector", selected)
        s.grabber.write_feature("BalanceRatio", 1.0)
    before = s.light().channels
    assert abs(before["R"] / before["G"] - 1) > 0.2
    assert "Balanced" in s.run(on(REGION, balance)), s.failures
    light = s.light().channels
    assert light["R"] == pytest.approx(light["G"], rel=0.03)
    assert light["B"] == pytest.approx(light["G"], rel=0.03)


def test_the_simulated_cameras_own_once(sim):
    s = sim("pixel_format=RGB8&exposure=100")
    assert has_once(s.grabber, Role.EXPOSURE) and has_once(s.grabber, Role.BALANCE_RATIO)
    before = s.light(None).mean
    assert "ExposureAuto is done" in s.run(lambda bench: let_camera(bench, Role.EXPOSURE)), s.failures
    assert s.value("ExposureAuto") == "Off"
    assert s.light(None).mean > before + 0.1
    assert revert(s.hands, Direction.UNDO) == []
    assert s.value("ExposureTime") == pytest.approx(100)


def test_a_camera_without_automatic_has_no_once(stage):
    s = stage()
    assert not has_once(s.grabber, Role.EXPOSURE)
    s.run(lambda bench: let_camera(bench, Role.EXPOSURE))
    assert "does not regulate" in s.failures[0]


def test_no_frame_error_is_a_grabbers(stage):
    s = stage()
    s.grabber.sending.clear()
    bench = bench_module.TuningBench(s.hands, s.worker, None, lambda *_: None)
    bench._frames.close()
    with pytest.raises(FrameTimeoutError):
        bench.light(None)
