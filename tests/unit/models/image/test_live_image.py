"""The image to show: the newest frame, only as fast as it is painted, only what is looked at."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from fakes import ScriptedGrabber
from grabbergui.core import pfnc
from grabbergui.core.component import ComponentKind
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import Region
from grabbergui.models.image.live_image import ImageModel
from patience import until

MONO8 = pfnc.by_name("Mono8")


def frame(number, width=64, height=48, pixel_format=MONO8):
    return Frame(np.full(width * height * 2, number, np.uint8), width, height, pixel_format, number)


class Stream(ScriptedGrabber):
    def send(self, *frames):
        for one in frames:
            self._fanout.put(one)


@pytest.fixture
def stream():
    return Stream()


@pytest.fixture
def image(stream):
    model = ImageModel()
    model.attach(stream)
    yield model
    assert model.detach(2)
    assert not [thread for thread in threading.enumerate() if thread.name == "display"]


def test_a_frame_is_offered_once_ready_to_paint(stream, image):
    ready = []
    image.ready.connect(lambda: ready.append(threading.current_thread().name))
    stream.send(frame(7))
    taken = until(image.take)
    assert taken.frame.frame_id == 7
    assert taken.image.pixels.shape == (48, 64)
    assert (taken.image.pixels == 7).all()
    assert image.take() is None
    assert ready == ["display"]


@pytest.mark.parametrize(("name", "channels"), [("Mono8", 1), ("RGB8", 3)])
def test_the_mean_is_that_of_all_components(stream, image, name, channels):
    pixels = np.zeros((48, 64, channels), np.uint8)
    pixels[..., 0] = 90
    stream.send(Frame(pixels.reshape(-1), 64, 48, pfnc.by_name(name), 1))
    until(image.take)
    assert image.mean == pytest.approx(90 / channels)


def test_how_much_is_saturated_is_estimated_without_being_asked(stream, image):
    pixels = np.zeros((480, 64), np.uint8)
    pixels[:120] = 255
    stream.send(Frame(pixels.reshape(-1), 64, 480, pfnc.by_name("BayerRG8"), 1))
    until(image.take)
    assert image.saturated == pytest.approx(0.25, abs=0.01)
    image.restarted()
    assert image.saturated is None


def test_nothing_is_converted_until_the_window_paints_and_then_the_newest_is_shown(stream, image):
    stream.send(frame(1))
    until(lambda: image.converted == 1)
    for number in range(2, 8):
        stream.send(frame(number))
    assert image.converted == 1
    assert until(image.take).frame.frame_id == 1
    assert until(image.take).frame.frame_id == 7
    until(lambda: image.received == 7)
    assert image.converted == 2


def test_only_the_viewport_is_converted_at_the_screens_resolution(stream, image):
    image.set_viewport(Region(8, 4, 32, 24), (16, 12))
    stream.send(frame(3))
    shown = until(image.take).image
    assert shown.region == Region(8, 4, 32, 24)
    assert shown.pixels.shape == (12, 16)


def test_a_standing_image_follows_the_view(stream, image):
    stream.send(frame(5))
    until(image.take)
    image.set_viewport(Region(0, 0, 10, 10), (10, 10))
    again = until(image.take)
    assert again.frame.frame_id == 5
    assert again.image.region == Region(0, 0, 10, 10)
    assert image.received == 1, "looking elsewhere is no new frame"


def test_an_unsupported_format_is_reported_once_and_the_frame_is_kept(stream, image):
    problems = []
    image.failed.connect(problems.append)
    strange = pfnc.by_code(0x81090001)
    stream.send(frame(1, pixel_format=strange))
    until(lambda: problems)
    stream.send(frame(2, pixel_format=strange))
    until(lambda: image.frame is not None and image.frame.frame_id == 2)
    assert len(problems) == 1
    assert "0x81090001" in problems[0]
    stream.send(frame(3))
    assert until(image.take).frame.frame_id == 3
    assert image.problem == ""


def test_a_payload_that_is_too_short_does_not_end_the_image(stream, image):
    short = Frame(np.zeros(10, np.uint8), 64, 48, MONO8, 1)
    stream.send(short)
    until(lambda: image.problem)
    stream.send(frame(2))
    assert until(image.take).frame.frame_id == 2


def test_the_last_frame_stays_after_the_source_is_closed(stream, image):
    stream.send(frame(9))
    until(image.take)
    assert image.detach(2)
    assert image.frame.frame_id == 9


def test_a_frame_that_lacks_components_of_those_before_is_left_out_for_a_moment(stream, image, monkeypatch):
    monkeypatch.setattr("grabbergui.models.image.live_image.COMPONENT_WAIT", 1000.0)
    whole, lacking = frame(1), frame(2)
    whole.parts = (whole.components[0], replace(whole.components[0], kind=ComponentKind.RANGE))
    stream.send(whole)
    assert until(image.take).labels == ("Intensity", "Range")
    stream.send(lacking)
    until(lambda: image.received == 2)
    after = replace(whole, frame_id=3)
    stream.send(after)
    assert until(image.take).frame.frame_id == 3

    monkeypatch.setattr("grabbergui.models.image.live_image.COMPONENT_WAIT", 0.0)
    stream.send(frame(4))
    shown = until(image.take)
    assert (shown.labels, shown.frame.frame_id) == ((), 4)


def test_a_pause_at_any_moment_shows_the_frame_that_it_held(stream, monkeypatch):
    """Also between two looks of the display's thread at whether an image is wanted again."""
    held, armed = frame(3), threading.Event()

    class Interrupted(threading.Event):
        def is_set(self):
            found = super().is_set()
            if armed.is_set() and threading.current_thread().name == "display":
                armed.clear()
                model.freeze(held)
            return found

    with monkeypatch.context() as patch:
        patch.setattr(threading, "Event", Interrupted)
        model = ImageModel()
    model.attach(stream)
    stream.send(frame(7))
    until(model.take)
    armed.set()
    stream.send(frame(8))
    assert until(model.take).frame is held
    assert model.detach(2)
