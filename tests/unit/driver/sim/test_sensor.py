"""The image answers the controls."""

import numpy as np
import pytest

from every_case import every_case
from grabbergui.core.pfnc import Family, by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim import sensor
from grabbergui.driver.sim.enumerations import BinningMode, TestPattern
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.scene import ILLUMINANT, UNIT, Scene, SceneView
from grabbergui.driver.sim.sensor import draw_pattern
from pixel_formats import CONVERTIBLE

SMALL = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.OFFSET_X: 0, reg.OFFSET_Y: 0, reg.BLACK_LEVEL: 0.0}


class StillScene(Scene):
    """One image that does not move."""

    def __init__(self, image):
        self._view = SceneView(image)

    def view(self, time_ns):
        return self._view


def flat(level):
    """A scene that is grey everywhere, under the usual light."""
    image = np.empty((SENSOR_HEIGHT, SENSOR_WIDTH, 3), np.uint16)
    image[...] = np.array(ILLUMINANT) * level * UNIT
    return StillScene(image)


@pytest.fixture(scope="module")
def grey():
    return flat(0.25)


@pytest.fixture(scope="module")
def ramp():
    """Red rises to the right, green downwards, blue stays."""
    image = np.zeros((SENSOR_HEIGHT, SENSOR_WIDTH, 3), np.uint16)
    image[:, :, 0] = np.arange(SENSOR_WIDTH) * 2
    image[:, :, 1] = np.arange(SENSOR_HEIGHT)[:, None] * 2
    image[:, :, 2] = 3000
    return StillScene(image)


@pytest.fixture
def lit(make_bench, grey):
    def make(**power_on):
        bench = make_bench({**SMALL, **{getattr(reg, name): value for name, value in power_on.items()}}, grey)
        bench.start()
        return bench

    return make


@pytest.mark.parametrize("name", ["Mono8", "Mono12", "RGB8", "BayerRG16"])
def test_twice_the_exposure_is_twice_the_brightness_until_white(lit, name):
    bench = lit(PIXEL_FORMAT=by_name(name).code, EXPOSURE_TIME=5000.0)
    exposures = (5000.0, 10_000.0, 20_000.0, 100_000.0)
    means = [bench.image_with(reg.EXPOSURE_TIME, exposure).mean() for exposure in exposures]
    assert means[1] == pytest.approx(2 * means[0], abs=0.01)
    assert means[2] == pytest.approx(4 * means[0], abs=0.01)
    assert means[3] > 0.99


def test_six_decibels_double_the_brightness(lit):
    bench = lit()
    plain = bench.image().mean()
    assert bench.image_with(reg.GAIN_RAW, 602).mean() == pytest.approx(2 * plain, abs=0.01)


@pytest.mark.parametrize("latency", [1, 2, 4])
def test_a_setting_takes_effect_some_frames_later(lit, latency):
    bench = lit(EXPOSURE_TIME=5000.0, SETTING_LATENCY=latency)
    before = bench.image().mean()
    bench.set(reg.EXPOSURE_TIME, 10_000.0)
    exposures = [bench.plan().settings.exposure_us for _ in range(latency + 2)]
    assert exposures == [5000.0] * latency + [10_000.0] * 2
    assert bench.image().mean() == pytest.approx(2 * before, abs=0.01)


def test_a_triggered_frame_obeys_at_once(lit):
    bench = lit(EXPOSURE_TIME=5000.0, SETTING_LATENCY=4)
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.set(reg.EXPOSURE_TIME, 10_000.0)
    bench.clock.advance(0.1)
    bench.set(reg.TRIGGER_SOFTWARE[0], 1)
    assert bench.plan().settings.exposure_us == 10_000.0


def test_black_level_is_added(lit):
    bench = lit(EXPOSURE_TIME=10.0, BLACK_LEVEL=20.0)
    assert bench.image().mean() * 255 == pytest.approx(20, abs=0.5)


@pytest.mark.parametrize("gamma", [0.5, 2.0])
def test_gamma_is_the_exponent(lit, gamma):
    bench = lit(PIXEL_FORMAT=by_name("Mono16").code)
    linear = bench.image().mean()
    assert bench.image_with(reg.GAMMA, gamma).mean() == pytest.approx(linear**gamma, abs=0.01)


def test_cameras_that_see_the_same_scene_keep_their_own_optics(lit):
    deep = by_name("Mono16").code
    straight, curved = lit(PIXEL_FORMAT=deep), lit(PIXEL_FORMAT=deep, GAMMA=2.0)
    linear = straight.image().mean()
    for _ in range(2):
        assert curved.image().mean() == pytest.approx(linear**2, abs=0.01)
        assert straight.image().mean() == pytest.approx(linear, abs=0.01)


def test_cameras_that_are_used_in_turn_prepare_the_scene_once_each(lit, monkeypatch):
    prepared = []
    prepare = sensor._prepare
    monkeypatch.setattr(sensor._Prepared, "_latest", ())
    monkeypatch.setattr(sensor, "_prepare", lambda *wanted: (prepared.append(wanted[2]), prepare(*wanted))[1])
    for name in ("Mono8", "BayerRG8", "Mono8", "BayerRG8"):
        lit(PIXEL_FORMAT=by_name(name).code, GAMMA=1.5).image()
    assert prepared == ["mono", "RG"]


def test_balance_acts_on_its_colour(lit):
    bench = lit(PIXEL_FORMAT=by_name("RGB8").code)
    red, green, blue = bench.image().mean((0, 1))
    assert red == pytest.approx(green, abs=0.01) and blue == pytest.approx(green, abs=0.01)
    assert bench.image_with(reg.BALANCE_RATIO[0], 3.2).mean((0, 1)) == pytest.approx(
        [2 * red, green, blue], abs=0.01
    )


def test_noise_grows_with_gain_and_is_the_same_for_the_same_frame(make_bench, grey):
    def frame(gain):
        bench = make_bench({**SMALL, reg.GAIN_RAW: gain, reg.EXPOSURE_TIME: 1000.0}, grey)
        bench.start()
        return bench.image()

    assert np.array_equal(frame(0), frame(0))
    assert frame(2400).std() > 5 * frame(0).std()


def test_binning_averages_or_sums(lit):
    bench = lit(BINNING_HORIZONTAL=2, BINNING_VERTICAL=2)
    averaged = bench.image().mean()
    assert bench.image_with(reg.BINNING_HORIZONTAL_MODE, BinningMode.SUM).mean() == pytest.approx(
        2 * averaged, abs=0.01
    )


@pytest.fixture
def window(make_bench, ramp):
    def make(name="RGB8", **power_on):
        values = {**SMALL, reg.BALANCE_RATIO[0]: 1.0, reg.BALANCE_RATIO[2]: 1.0}
        values[reg.PIXEL_FORMAT] = by_name(name).code
        values.update({getattr(reg, register): value for register, value in power_on.items()})
        bench = make_bench(values, ramp)
        bench.start()
        return bench.image() * UNIT

    return make


def test_offsets_move_the_window(window):
    image = window(OFFSET_X=1000, OFFSET_Y=500)
    assert image[0, 0, 0] == pytest.approx(2000, abs=80)
    assert image[0, 0, 1] == pytest.approx(1000, abs=80)


def test_reversing_mirrors_the_sensor(window):
    image = window(REVERSE_X=1, REVERSE_Y=1)
    assert image[0, 0, 0] == pytest.approx(2 * SENSOR_WIDTH, abs=80)
    assert image[0, 0, 1] == pytest.approx(2 * SENSOR_HEIGHT, abs=80)


@pytest.mark.parametrize("mirrored", [0, 1])
@pytest.mark.parametrize("order", ["RG", "GR", "GB", "BG"])
def test_bayer_pixels_see_their_colour_in_all_orders(window, order, mirrored):
    place = {"OFFSET_X": 1000, "OFFSET_Y": 1400, "REVERSE_X": mirrored}
    rgb = window("RGB8", **place)
    raw = window(f"Bayer{order}8", **place)
    sites = {letter: rgb[:, :, index] for index, letter in enumerate("RGB")}
    assert raw[0::2, 0::2] == pytest.approx(sites[order[0]][0::2, 0::2], abs=90)
    assert raw[0::2, 1::2] == pytest.approx(sites[order[1]][0::2, 1::2], abs=90)
    below = {"RG": "GB", "GR": "BG", "GB": "RG", "BG": "GR"}[order]
    assert raw[1::2, 0::2] == pytest.approx(sites[below[0]][1::2, 0::2], abs=90)
    assert raw[1::2, 1::2] == pytest.approx(sites[below[1]][1::2, 1::2], abs=90)


@every_case("pixel_format", CONVERTIBLE, ids=str)
def test_every_format_fills_its_payload(lit, pixel_format):
    bench = lit(PIXEL_FORMAT=pixel_format.code)
    plan, payload = bench.payload()
    assert len(payload) == plan.payload_bytes == pixel_format.image_bytes(64, 48)
    assert payload.any() or pixel_format.depth <= 2  # the scene is darker than a quarter


def test_the_default_scene_moves(make_bench):
    bench = make_bench(SMALL | {reg.OFFSET_X: 1724, reg.OFFSET_Y: 956})
    bench.start()
    first = bench.image()
    bench.clock.advance(2)
    assert np.abs(bench.image() - first).max() > 0.05


def test_ramps_rise_by_one_and_move_with_the_frame():
    still = draw_pattern(TestPattern.GREY_HORIZONTAL_RAMP, 300, 2, 7, by_name("Mono8"))
    assert still[0, :3].tolist() == [0, 1, 2] and still[1, 256] == 0
    moving = draw_pattern(TestPattern.GREY_VERTICAL_RAMP_MOVING, 2, 4, 7, by_name("Mono12"))
    assert moving[:, 0].tolist() == [7 << 4, 8 << 4, 9 << 4, 10 << 4]


def test_white_is_the_highest_value_of_each_depth():
    for name, value in (("Mono8", 255), ("Mono10", 1023), ("Mono12", 4095), ("BayerRG16", 65535)):
        image = draw_pattern(TestPattern.WHITE, 4, 4, 1, by_name(name))
        assert image.min() == image.max() == value


def test_colour_bars_are_colours():
    bars = draw_pattern(TestPattern.COLOR_BAR, 80, 2, 1, by_name("RGB8"))
    assert [tuple(map(int, bars[0, x])) for x in (5, 15, 55, 75)] == [
        (255, 255, 255),
        (255, 255, 0),
        (255, 0, 0),
        (0, 0, 0),
    ]


def test_patterns_do_not_answer_to_exposure(lit):
    bench = lit(TEST_PATTERN=TestPattern.GREY_HORIZONTAL_RAMP)
    first = bench.image()
    bench.set(reg.EXPOSURE_TIME, 50_000.0)
    assert np.array_equal(bench.image(), first)
    assert first[0, :4] * 255 == pytest.approx([0, 1, 2, 3])


def test_the_frame_counter_is_drawn_over_the_scene(lit):
    bench = lit(TEST_PATTERN=TestPattern.FRAME_COUNTER)
    first, second = bench.image(), bench.image()
    assert first.max() == 1.0 and first.min() == 0.0
    assert np.abs(first - second).max() == 1.0


def test_mono_formats_are_grey_whatever_the_balance(lit):
    assert by_name("Mono8").family is Family.MONO
    bench = lit()
    before = bench.image().mean()
    assert bench.image_with(reg.BALANCE_RATIO[0], 4.0).mean() == pytest.approx(before, abs=0.005)


def test_what_takes_long_is_done_before_the_first_frame(make_bench, grey, monkeypatch):
    """Otherwise the first frames come late, one right after the other, and the rate reads too high."""
    bench = make_bench({}, grey)
    bench.model.prepare()
    bench.start()
    monkeypatch.setattr(sensor, "_prepare", None)
    monkeypatch.setattr(sensor, "_noise", None)
    assert bench.image().mean() > 0.1
