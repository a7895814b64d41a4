"""A camera that lost its power is set as it was, compared, and says what is not."""

import os
import queue as queue_module
import random
from contextlib import closing

import pytest

from grabbergui import sources
from grabbergui.core.errors import DeviceStatusError, FeatureError
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.settings import SettingKey
from grabbergui.core.uri import SourceUri
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.setting_writer import SettingsMemory
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.device import create_device
from grabbergui.driver.sim.enumerations import EventSelector
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE, until
from random_settings import any_write, capture_all, differences

URI = "sim:?width=64&height=48&fps=100"
ADDRESS = "127.13.1.1"
SMALL = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 50.0, reg.EXPOSURE_TIME: 1000.0}
ROUNDS = int(os.environ.get("GRABBERGUI_POWER_CYCLES", "2"))
"Random settings that are tried on each kind of camera; fifty take some minutes."


class InProcess:
    """The simulated camera in this process, and the switch of its power."""

    def __init__(self):
        self.camera = sources.create(URI)
        self.camera.open()

    def lose_power(self):
        self.camera.device.on_lost("the power is off")
        self.camera.device.model = sources.create(URI).device.model

    def close(self):
        self.camera.close()


def switched_on():
    """Return a GigE Vision camera that waits long for its host: a machine may stand still for a while."""
    simulated = GigeCamera(ADDRESS, power_on=SMALL)
    simulated.control.memory.set(gev.HEARTBEAT_TIMEOUT, int(PATIENCE * 1000))
    return simulated


class OnTheNetwork:
    """A simulated GigE Vision camera, and the switch of its power."""

    def __init__(self):
        self.simulated = switched_on()
        self.camera = sources.create(f"gige:{ADDRESS}")
        self.camera.open()

    def lose_power(self):
        self.simulated.close()
        until(lambda: self.camera._reconnecting is not None, "the loss")
        self.simulated = switched_on()

    def close(self):
        self.camera.close()
        self.simulated.close()


@pytest.fixture(params=[InProcess, OnTheNetwork])
def bench(request):
    bench = request.param()
    yield bench
    bench.close()


@pytest.fixture
def sim():
    bench = InProcess()
    yield bench
    bench.close()


def power_cycle(bench):
    """Take the camera's power away and wait until it is back; what the camera says of its return."""
    states = queue_module.Queue()
    listener = bench.camera.connection_changed.connect(lambda state, why: states.put((state, why)))
    bench.lose_power()
    assert states.get(timeout=PATIENCE)[0] is ConnectionState.LOST
    state, why = states.get(timeout=PATIENCE)
    bench.camera.connection_changed.disconnect(listener)
    assert state is ConnectionState.OPEN
    return why


@pytest.mark.parametrize("seed", range(ROUNDS))
def test_random_settings_are_equal_before_and_after_a_power_loss(bench, seed):
    print(f"seed {seed}")
    camera, chance = bench.camera, random.Random(seed)
    streams = seed % 2 == 0
    if streams:
        camera.start()
    for _ in range(60):
        any_write(camera, chance)
    before = capture_all(camera)

    assert power_cycle(bench) == "set as before"

    assert differences(before, capture_all(camera)) == []
    assert camera.streaming == streams


def test_a_mode_that_a_write_switched_off_stays_off(sim):
    sim.camera.write_feature("ExposureAuto", "Continuous")
    sim.camera.write_feature("ExposureTime", 5000.0)

    assert power_cycle(sim) == "set as before"

    assert sim.camera.feature("ExposureAuto").value == "Off"
    assert sim.camera.feature("ExposureTime").value == 5000.0


def test_what_the_camera_found_by_itself_stays_when_its_mode_goes_off(sim):
    sim.camera.start()
    sim.camera.write_feature("GainAuto", "Off")
    sim.camera.write_feature("ExposureTime", 100.0)
    sim.camera.write_feature("ExposureAuto", "Once")
    until(lambda: not sim.camera._writes().memory.regulated_once, "the end of the exposure's regulation")
    found = sim.camera.feature("ExposureTime").value
    assert found != 100.0

    assert power_cycle(sim) == "set as before"

    assert sim.camera.feature("ExposureAuto").value == "Off"
    assert sim.camera.feature("ExposureTime").value == pytest.approx(found)


def test_a_notification_that_was_on_once_is_off_when_its_event_has_come():
    """SFNC: EventNotification has the entry Once, too, and is no automatic mode."""
    device = create_device(SourceUri("sim"))
    before, notification = device.description().split(b'<Enumeration Name="EventNotification"')
    xml = before + b'<Enumeration Name="EventNotification"' + notification.replace(b'"On"', b'"Once"', 1)
    device.description = lambda: xml
    with closing(DeviceGrabber(device)) as camera:
        camera.open()
        first, second = (
            SettingKey("EventNotification", (("EventSelector", event),)) for event in ("FrameStart", "Test")
        )
        camera.write_setting(first, "Once")
        camera.write_setting(second, "Once")
        remembered = camera._writes().memory.settings
        device.model.memory.set(reg.EVENT_NOTIFICATION[EventSelector.FRAME_START], 0)
        until(lambda: remembered[first] == "Off", "the end of the notification")
        assert remembered[second] == "Once"
        camera.write_feature("EventSelector", "Test")
        device.model.memory.set(reg.EVENT_NOTIFICATION[EventSelector.TEST], 0)
        until(lambda: remembered[second] == "Off", "the end of the other, by the same thread")


def test_what_is_hidden_at_the_moment_is_set_too(sim):
    sim.camera.write_feature("AcquisitionMode", "MultiFrame")
    sim.camera.write_feature("AcquisitionFrameCount", 7)
    sim.camera.write_feature("AcquisitionMode", "Continuous")

    assert power_cycle(sim) == "set as before"

    sim.camera.write_feature("AcquisitionMode", "MultiFrame")
    assert sim.camera.feature("AcquisitionFrameCount").value == 7


def test_triggers_that_were_switched_on_while_streaming_stay_on(sim):
    sim.camera.start()
    sim.camera.write_feature("TriggerMode", "On")

    assert power_cycle(sim) == "set as before"

    assert sim.camera.feature("TriggerMode").value == "On"
    assert sim.camera.streaming


def test_a_mode_of_acquisition_that_was_chosen_while_streaming_stays(sim):
    sim.camera.start()
    sim.camera.write_feature("AcquisitionMode", "MultiFrame")
    sim.camera.write_feature("AcquisitionFrameCount", 7)

    assert power_cycle(sim) == "set as before"

    assert sim.camera.streaming
    assert sim.camera.feature("AcquisitionMode").value == "MultiFrame"
    assert sim.camera.feature("AcquisitionFrameCount").value == 7


def test_a_set_that_was_loaded_is_loaded_again_and_what_came_before_it_is_not_set(sim):
    sim.camera.write_feature("Gain", 6.0)
    sim.camera.execute_setting(SettingKey("UserSetLoad", (("UserSetSelector", "Default"),)))
    sim.camera.write_feature("ExposureTime", 5000.0)

    assert power_cycle(sim) == "set as before"

    assert sim.camera.feature("Gain").value == 0.0
    assert sim.camera.feature("ExposureTime").value == 5000.0


def test_settings_that_cannot_be_restored_are_reported(sim, monkeypatch):
    sim.camera.write_feature("Gain", 6.0)
    really = sim.camera.write_setting

    def refuse(key, value):
        if key.name == "Gain":
            raise FeatureError("Gain=6: the camera answered: busy", "Gain")
        return really(key, value)

    monkeypatch.setattr(sim.camera, "write_setting", refuse)
    assert power_cycle(sim) == "but not as before: Gain=6: the camera answered: busy"
    assert sim.camera.unlike_before == ("Gain=6: the camera answered: busy",)


def test_a_value_restored_differently_is_reported_and_logged_once(sim, caplog):
    sim.camera.write_feature("Gain", 6.0)
    sim.camera._writes().memory.note(SettingKey("Gain"), 6.004)
    assert power_cycle(sim) == "but not as before: Gain is 6 instead of 6.004"
    assert caplog.text.count("Gain is 6 instead of 6.004") == 1


def as_if_set_before_it_was_opened(camera, key, value):
    """Set a value, as another program did before; here it is only read."""
    camera.write_setting(key, value)
    camera._writes().memory = SettingsMemory()
    assert camera.read_setting(key).value == value


def test_what_was_known_under_a_selector_is_compared_under_it(sim):
    delay = SettingKey("TriggerDelay", (("TriggerSelector", "FrameBurstStart"),))
    sim.camera.write_feature("TriggerSelector", "FrameBurstStart")
    as_if_set_before_it_was_opened(sim.camera, delay, 20.0)  # the selector is elsewhere afterwards
    assert power_cycle(sim) == f"set as before; changed meanwhile, not by us: {delay} is 0 instead of 20"
    assert sim.camera.feature("TriggerSelector").value == "FrameStart"


def test_a_comparison_with_what_was_known_ends_in_time(sim, monkeypatch):
    as_if_set_before_it_was_opened(sim.camera, SettingKey("Gain"), 6.0)
    monkeypatch.setattr("grabbergui.driver.setting_writer.COMPARE_SECONDS", -1.0)
    assert power_cycle(sim) == "set as before"


def test_a_refused_write_leaves_the_automatic_mode_as_it_was(sim, monkeypatch):
    sim.camera.write_feature("ExposureAuto", "Continuous")
    nodes = sim.camera._opened()
    really = nodes.write_and_read

    def refuse(name, value):
        if name == "ExposureTime":
            raise FeatureError("ExposureTime: the camera answered: busy", name)
        return really(name, value)

    monkeypatch.setattr(nodes, "write_and_read", refuse)
    with pytest.raises(FeatureError, match="busy"):
        sim.camera.write_feature("ExposureTime", 5000.0)
    assert sim.camera.feature("ExposureAuto").value == "Continuous"


def test_a_write_whose_mode_cannot_be_switched_on_again_reports_its_own_refusal(sim, monkeypatch, caplog):
    """A camera that refuses one write now and then refuses the next, too."""
    sim.camera.write_feature("ExposureAuto", "Continuous")
    device, written = sim.camera.device, []
    write = device.write

    def refuse_all_but_the_first(address, data):
        written.append(address)
        if len(written) > 1:
            raise DeviceStatusError("the device is busy", 0x8007)
        write(address, data)

    monkeypatch.setattr(device, "write", refuse_all_but_the_first)
    with pytest.raises(FeatureError, match="ExposureTime=5000: the camera answered: the device is busy"):
        sim.camera.write_feature("ExposureTime", 5000.0)
    assert len(written) == 3
    assert "ExposureAuto stays Off: ExposureAuto=Continuous: the camera answered" in caplog.text
