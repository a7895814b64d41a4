"""The behaviour of the registers, without any transport."""

import threading
from itertools import pairwise

import cv2
import numpy as np
import pytest

from grabbergui.core.component import ComponentKind
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import (
    AcquisitionMode,
    Auto,
    ComponentSelector,
    Compression,
    EventSelector,
    File,
    PtpStatus,
    TestPattern,
    TriggerSource,
    UserSetSelector,
)
from grabbergui.driver.sim.memory import Refusal, RegisterRefusedError
from grabbergui.driver.sim.sensor import draw_pattern
from patience import PATIENCE, until

SMALL = {reg.WIDTH: 128, reg.HEIGHT: 128, reg.OFFSET_X: 900, reg.OFFSET_Y: 900}
CHART = {reg.WIDTH: 1224, reg.HEIGHT: 1024}


def refused(bench, register, value):
    with pytest.raises(RegisterRefusedError) as caught:
        bench.set(register, value)
    return caught.value.reason


def test_no_register_overlaps_another():
    ordered = sorted(reg.ALL, key=lambda register: register.address)
    assert all(first.end <= second.address for first, second in pairwise(ordered))
    assert all(register.address >= 0x100000 for register in ordered)


def test_refusals_say_why(bench):
    assert refused(bench, reg.SENSOR_WIDTH_REGISTER, 1) is Refusal.WRITE_PROTECT
    assert refused(bench, reg.EXPOSURE_TIME, float("nan")) is Refusal.INVALID_PARAMETER
    assert refused(bench, reg.WIDTH, 100 + 1) is Refusal.INVALID_PARAMETER
    assert refused(bench, reg.LINK_THROUGHPUT_LIMIT, 0) is Refusal.INVALID_PARAMETER
    for address, data in (
        (0x50, bytes(4)),
        (reg.WIDTH.address + 2, bytes(4)),
        (reg.EXPOSURE_TIME.address, bytes(4)),
    ):
        with pytest.raises(RegisterRefusedError):
            bench.model.write(address, data)
    with pytest.raises(RegisterRefusedError):
        bench.model.read(0x50, 4)


def test_several_registers_in_one_write(bench):
    bench.model.write(reg.WIDTH.address, bytes.fromhex("00000280000001e0"))
    assert (bench.get(reg.WIDTH), bench.get(reg.HEIGHT)) == (640, 480)


def test_a_string_may_be_written_in_part(bench):
    bench.model.write(reg.DEVICE_USER_ID.address, b"left")
    assert bench.get(reg.DEVICE_USER_ID) == "left"


def test_the_intensity_is_always_sent(bench):
    intensity = reg.COMPONENT_ENABLE[ComponentSelector.INTENSITY]
    assert refused(bench, intensity, 0) is Refusal.ACCESS_DENIED
    bench.model.files.replace(File.USER_SET1, f"{intensity.name} = 0\n".encode())
    bench.set(reg.USER_SET_SELECTOR, UserSetSelector.USER_SET1)
    bench.set(reg.USER_SET_LOAD, 1)
    bench.set(reg.GENDC_STREAMING_MODE, 1)
    bench.start()
    plan, payload = bench.payload()
    assert plan.settings.components == (ComponentKind.INTENSITY,)
    assert len(payload) == plan.payload_bytes > plan.settings.image_bytes


# Its implementation in OpenCV takes 32 lines and columns at least.
@pytest.mark.parametrize(("width", "height"), [(16, 2), (4096, 30), (16, 2160), (32, 32)])
@pytest.mark.parametrize("name", ["Mono8", "RGB8", "BayerRG12"])
def test_small_images_are_compressed_too(bench, width, height, name):
    bench.set(reg.OFFSET_X, 0)
    bench.set(reg.OFFSET_Y, 0)
    bench.set(reg.WIDTH, width)
    bench.set(reg.HEIGHT, height)
    bench.set(reg.PIXEL_FORMAT, by_name(name).code)
    bench.set(reg.TEST_PATTERN, TestPattern.GREY_VERTICAL_RAMP)
    bench.set(reg.IMAGE_COMPRESSION_MODE, Compression.JPEG2000)
    bench.start()
    decoded = cv2.imdecode(bench.payload()[1], cv2.IMREAD_UNCHANGED)
    expected = draw_pattern(TestPattern.GREY_VERTICAL_RAMP, width, height, 1, by_name(name))
    if name == "RGB8":
        decoded = decoded[:, :, ::-1]
    difference = decoded.astype(int) - (expected >> (4 if name == "BayerRG12" else 0))
    assert decoded.dtype == np.uint8 and np.abs(difference).mean() < 8


def test_after_power_on_the_middle_of_the_sensor_is_seen(bench):
    assert (bench.get(reg.WIDTH), bench.get(reg.HEIGHT)) == (1224, 1024)
    assert (bench.get(reg.WIDTH_MAX), bench.get(reg.HEIGHT_MAX)) == (4096, 2160)
    assert 2 * bench.get(reg.OFFSET_X) + 1224 == 4096
    assert 2 * bench.get(reg.OFFSET_Y) + 1024 == 2160


def test_offsets_shrink_for_a_larger_image(bench):
    bench.set(reg.WIDTH, 4096)
    assert bench.get(reg.OFFSET_X) == 0
    bench.set(reg.WIDTH, 640)
    bench.set(reg.OFFSET_X, 4096 - 640)
    assert refused(bench, reg.OFFSET_X, 4096 - 638) is Refusal.INVALID_PARAMETER


def test_binning_shrinks_the_sensor(bench):
    bench.set(reg.WIDTH, 4096)
    bench.set(reg.BINNING_HORIZONTAL, 3)
    assert bench.get(reg.WIDTH_MAX) == 1360
    assert bench.get(reg.WIDTH) == 1360
    assert refused(bench, reg.WIDTH, 1368) is Refusal.INVALID_PARAMETER


def test_the_payload_follows_format_and_chunks(bench):
    bench.set(reg.WIDTH, 640)
    bench.set(reg.HEIGHT, 480)
    bench.set(reg.PIXEL_FORMAT, by_name("Mono12p").code)
    assert bench.get(reg.PAYLOAD_SIZE) == 640 * 480 * 3 // 2
    bench.set(reg.CHUNK_MODE_ACTIVE, 1)
    assert bench.get(reg.PAYLOAD_SIZE) == 640 * 480 * 3 // 2 + 8 + 4 * 16


def test_the_format_is_locked_while_streaming(bench):
    bench.start()
    for register, value in ((reg.WIDTH, 640), (reg.PIXEL_FORMAT, by_name("Mono16").code)):
        assert refused(bench, register, value) is Refusal.ACCESS_DENIED
    bench.set(reg.OFFSET_X, 0)
    bench.stop()
    bench.set(reg.WIDTH, 640)


def test_frames_come_at_the_rate_asked_for(make_bench):
    bench = make_bench({**SMALL, reg.FRAME_RATE: 50.0})
    bench.start()
    plans = [bench.plan() for _ in range(4)]
    assert [plan.frame_id for plan in plans] == [1, 2, 3, 4]
    gaps = [b.timestamp_ns - a.timestamp_ns for a, b in pairwise(plans)]
    assert gaps == [20_000_000] * 3


def test_a_wait_for_a_frame_can_be_ended(bench):
    plans = []
    waiting = threading.Thread(target=lambda: plans.append(bench.model.next_frame(10 * PATIENCE)))
    waiting.start()
    bench.model.wake()
    waiting.join(PATIENCE)
    assert plans == [None]


def test_a_long_exposure_slows_the_frames(bench):
    bench.set(reg.EXPOSURE_TIME, 100_000.0)
    assert bench.get(reg.FRAME_RATE) == pytest.approx(9.998, abs=0.01)
    bench.set(reg.EXPOSURE_TIME, 1000.0)
    assert bench.get(reg.FRAME_RATE) == 30.0


def test_the_link_limit_slows_the_frames(bench):
    bench.set(reg.LINK_THROUGHPUT_LIMIT_MODE, 1)
    bench.set(reg.LINK_THROUGHPUT_LIMIT, 10_000_000)
    rate = bench.get(reg.RESULTING_FRAME_RATE)
    assert rate == pytest.approx(10_000_000 / (1224 * 1024))
    assert bench.get(reg.LINK_CURRENT_THROUGHPUT) == pytest.approx(10_000_000, abs=2)


def test_a_frame_is_ready_only_when_its_exposure_is_over(bench):
    bench.start()
    bench.clock.advance(0.009)
    assert bench.model.next_frame(0) is None
    bench.clock.advance(0.0011)
    assert bench.model.next_frame(0).timestamp_ns == 0


def test_a_scene_that_can_be_foretold_is_drawn_ahead_and_its_frame_leaves_when_the_exposure_is_over(bench):
    bench.model.sensor.scene.ahead = 0.004
    bench.start()
    bench.clock.advance(0.0059)
    assert bench.model.next_frame(0) is None
    bench.clock.advance(0.0002)
    plan = bench.model.next_frame(0)
    assert plan.timestamp_ns == 0
    out = np.zeros(plan.payload_bytes, np.uint8)
    drawing = threading.Thread(target=bench.model.render, args=(plan, out))
    drawing.start()
    until(out.any)
    drawing.join(0.1)
    assert drawing.is_alive()
    bench.clock.advance(0.0040)
    drawing.join(PATIENCE)
    assert not drawing.is_alive()


def test_single_and_multi_frame_end_by_themselves(make_bench):
    bench = make_bench(SMALL)
    for mode, count in ((AcquisitionMode.SINGLE_FRAME, 1), (AcquisitionMode.MULTI_FRAME, 3)):
        bench.set(reg.ACQUISITION_MODE, mode)
        bench.set(reg.ACQUISITION_FRAME_COUNT, 3)
        bench.start()
        assert all(bench.plan() is not None for _ in range(count))
        assert bench.plan() is None
        assert not bench.model.streaming
        assert bench.get(reg.TL_PARAMS_LOCKED) == 0


def test_a_software_trigger_yields_exactly_one_frame(bench):
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.start()
    assert bench.plan() is None
    bench.set(reg.TRIGGER_SOFTWARE[0], 1)
    assert bench.get(reg.TRIGGER_SOFTWARE[0]) == 0
    assert bench.plan().frame_id == 1
    assert bench.plan() is None


def test_the_trigger_delay_is_kept(bench):
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.set(reg.TRIGGER_DELAY[0], 5000.0)
    bench.start()
    bench.clock.advance(0.1)
    bench.set(reg.TRIGGER_SOFTWARE[0], 1)
    assert bench.plan().timestamp_ns == 105_000_000


def test_the_software_trigger_needs_its_mode_and_source(bench):
    assert refused(bench, reg.TRIGGER_SOFTWARE[0], 1) is Refusal.ACCESS_DENIED
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.set(reg.TRIGGER_SOURCE[0], TriggerSource.ACTION1)
    assert refused(bench, reg.TRIGGER_SOFTWARE[0], 1) is Refusal.ACCESS_DENIED


@pytest.mark.parametrize(("activation", "frames"), [(0, 2), (1, 1), (2, 3)])
def test_edges_of_the_users_signal_trigger(bench, activation, frames):
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.set(reg.TRIGGER_SOURCE[0], TriggerSource.USER_OUTPUT0)
    bench.set(reg.TRIGGER_ACTIVATION[0], activation)
    bench.start()
    taken = 0
    for level in (1, 1, 0, 1):
        bench.set(reg.USER_OUTPUT_VALUE, level)
        taken += bench.plan() is not None
    assert taken == frames


def test_an_action_triggers_where_it_is_the_source(bench):
    assert not bench.model.trigger_action()
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.set(reg.TRIGGER_SOURCE[0], TriggerSource.ACTION1)
    bench.start()
    assert bench.model.trigger_action(at=30_000_000)
    assert bench.plan().timestamp_ns == 30_000_000


@pytest.mark.parametrize("start", [20.0, 2_000.0, 29_000.0])
def test_exposure_auto_reaches_its_target_and_once_falls_back(make_bench, start):
    bench = make_bench({**SMALL, reg.EXPOSURE_TIME: start, reg.EXPOSURE_AUTO: Auto.ONCE})
    bench.set(reg.AUTO_TARGET_BRIGHTNESS, 0.5)
    bench.start()
    for _ in range(10):
        brightness = bench.image().mean()
        if bench.get(reg.EXPOSURE_AUTO) == Auto.OFF:
            break
    assert bench.get(reg.EXPOSURE_AUTO) == Auto.OFF
    assert brightness == pytest.approx(0.5, abs=0.02)
    assert bench.get(reg.EXPOSURE_TIME) != start


def test_exposure_auto_follows_the_scene_and_hides_its_register(make_bench):
    bench = make_bench({**SMALL, reg.EXPOSURE_AUTO: Auto.CONTINUOUS, reg.AUTO_EXPOSURE_UPPER: 200_000.0})
    bench.start()
    for target in (0.2, 0.6):
        bench.set(reg.AUTO_TARGET_BRIGHTNESS, target)
        for _ in range(6):
            brightness = bench.image().mean()
        assert brightness == pytest.approx(target, abs=0.02)
    assert bench.get(reg.EXPOSURE_AUTO) == Auto.CONTINUOUS
    assert refused(bench, reg.EXPOSURE_TIME, 100.0) is Refusal.ACCESS_DENIED


def test_gain_auto_takes_over_where_exposure_ends(make_bench):
    bench = make_bench(
        {
            **SMALL,
            reg.EXPOSURE_AUTO: Auto.CONTINUOUS,
            reg.GAIN_AUTO: Auto.CONTINUOUS,
            reg.EXPOSURE_TIME: 1000.0,
        }
    )
    bench.set(reg.AUTO_EXPOSURE_UPPER, 4000.0)
    bench.start()
    for _ in range(8):
        brightness = bench.image().mean()
    assert brightness == pytest.approx(0.4, abs=0.02)
    assert bench.get(reg.EXPOSURE_TIME) == pytest.approx(4000)
    assert bench.get(reg.GAIN_RAW) > 100


def test_gain_auto_once_gives_up_at_its_limit(make_bench):
    bench = make_bench({**SMALL, reg.GAIN_AUTO: Auto.ONCE, reg.EXPOSURE_TIME: 10.0})
    bench.start()
    for _ in range(8):
        bench.payload()
    assert bench.get(reg.GAIN_RAW) == 2400
    assert bench.get(reg.GAIN_AUTO) == Auto.OFF


@pytest.mark.parametrize("name", ["RGB8", "BayerRG8", "BayerGB12", "YUV422_8"])
def test_balance_white_auto_makes_grey_grey(make_bench, name):
    wrong = {reg.BALANCE_RATIO[0]: 0.7, reg.BALANCE_RATIO[2]: 2.5}
    bench = make_bench({**CHART, **wrong, reg.PIXEL_FORMAT: by_name(name).code, reg.EXPOSURE_TIME: 6000.0})
    bench.set(reg.BALANCE_WHITE_AUTO, Auto.ONCE)
    bench.start()
    for _ in range(8):
        bench.payload()
    assert bench.get(reg.BALANCE_WHITE_AUTO) == Auto.OFF
    assert bench.get(reg.BALANCE_RATIO[0]) == pytest.approx(1.6, rel=0.03)
    assert bench.get(reg.BALANCE_RATIO[2]) == pytest.approx(1.3, rel=0.03)


def test_user_sets_keep_what_was_saved(bench):
    bench.set(reg.EXPOSURE_TIME, 1234.0)
    bench.set(reg.WIDTH, 640)
    bench.set(reg.USER_SET_SELECTOR, UserSetSelector.USER_SET1)
    bench.set(reg.USER_SET_SAVE, 1)
    bench.set(reg.USER_SET_SELECTOR, UserSetSelector.DEFAULT)
    bench.set(reg.USER_SET_LOAD, 1)
    assert (bench.get(reg.EXPOSURE_TIME), bench.get(reg.WIDTH)) == (10_000.0, 1224)
    assert bench.get(reg.PAYLOAD_SIZE) == 1224 * 1024
    bench.set(reg.USER_SET_SELECTOR, UserSetSelector.USER_SET1)
    bench.set(reg.USER_SET_LOAD, 1)
    assert (bench.get(reg.EXPOSURE_TIME), bench.get(reg.WIDTH)) == (1234.0, 640)
    assert bench.get(reg.PAYLOAD_SIZE) == 640 * 1024


def test_the_factory_set_cannot_be_overwritten(bench):
    assert refused(bench, reg.USER_SET_SAVE, 1) is Refusal.ACCESS_DENIED


def test_a_reset_loads_the_default_set_and_starts_the_clock(bench):
    bench.set(reg.GAMMA, 2.0)
    bench.set(reg.USER_SET_SELECTOR, UserSetSelector.USER_SET2)
    bench.set(reg.USER_SET_SAVE, 1)
    bench.set(reg.USER_SET_DEFAULT, UserSetSelector.USER_SET2)
    bench.set(reg.GAMMA, 3.0)
    bench.start()
    bench.clock.advance(5)
    bench.set(reg.DEVICE_RESET, 1)
    assert bench.get(reg.GAMMA) == 2.0
    assert not bench.model.streaming
    assert bench.model.timestamp() == 0


def test_the_latch_holds_the_clock(bench):
    bench.clock.advance(1.5)
    bench.set(reg.TIMESTAMP_LATCH, 1)
    bench.clock.advance(1)
    assert bench.get(reg.TIMESTAMP_LATCH_VALUE) == 1_500_000_000


def test_ptp_sets_the_clock_by_its_master(bench):
    master = bench.clock.now + 1_700_000_000_000_000_000
    bench.set(reg.PTP_ENABLE, 1)
    assert bench.get(reg.PTP_STATUS) == PtpStatus.SLAVE
    assert bench.model.timestamp() == master
    assert refused(bench, reg.TIMESTAMP_RESET, 1) is Refusal.ACCESS_DENIED
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.set(reg.TRIGGER_SOURCE[0], TriggerSource.ACTION1)
    bench.start()
    assert bench.model.trigger_action(at=master + 40_000_000)
    assert bench.plan().timestamp_ns == master + 40_000_000
    bench.set(reg.DEVICE_RESET, 1)
    assert bench.model.timestamp() == 0
    assert bench.get(reg.PTP_STATUS) == PtpStatus.DISABLED


def test_streaming_warms_the_camera(bench):
    idle = bench.get(reg.DEVICE_TEMPERATURE[0])
    bench.start()
    bench.clock.advance(300)
    warm = bench.get(reg.DEVICE_TEMPERATURE[0])
    bench.stop()
    bench.clock.advance(300)
    assert idle < 42 < warm < 60
    assert bench.get(reg.DEVICE_TEMPERATURE[0]) < warm - 5


def test_chunks_follow_the_image(make_bench):
    bench = make_bench({**SMALL, reg.CHUNK_MODE_ACTIVE: 1, reg.CHUNK_ENABLE[4]: 0})
    bench.start()
    bench.plan()
    _, payload = bench.payload()
    tail = payload[128 * 128 :].tobytes().hex()
    expected = (
        "00001000" "00004000"
        "0000000000000002" "00001001" "00000008"
        "0000000001fca055" "00001002" "00000008"
        "40c3880000000000" "00001003" "00000008"
    )  # fmt: skip
    assert tail == expected


def test_enabled_events_are_reported(make_bench):
    bench = make_bench(SMALL)
    heard = []
    bench.model.on_event = lambda *event: heard.append(event)
    bench.start()
    bench.plan()
    assert heard == []
    bench.set(reg.EVENT_NOTIFICATION[EventSelector.EXPOSURE_END], 1)
    plan = bench.plan()
    assert heard == [(EventSelector.EXPOSURE_END, 2, plan.timestamp_ns + 10_000_000)]
    bench.set(reg.EVENT_NOTIFICATION[EventSelector.TEST], 1)
    bench.set(reg.TEST_EVENT_GENERATE, 1)
    assert heard[-1][0] is EventSelector.TEST


def test_a_trigger_that_comes_too_early_is_reported(bench):
    heard = []
    bench.model.on_event = lambda *event: heard.append(event)
    bench.set(reg.EVENT_NOTIFICATION[EventSelector.FRAME_TRIGGER_MISSED], 1)
    bench.set(reg.TRIGGER_MODE[0], 1)
    bench.start()
    bench.set(reg.TRIGGER_SOFTWARE[0], 1)
    bench.set(reg.TRIGGER_SOFTWARE[0], 1)
    assert [event for event, *_ in heard] == [EventSelector.FRAME_TRIGGER_MISSED]
