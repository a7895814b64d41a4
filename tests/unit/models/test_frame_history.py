import threading

import numpy as np

from fakes import ScriptedGrabber
from frames import frame_of
from grabbergui.models.frame_history import FrameHistory
from patience import PATIENCE, until


def image(number, size=10):
    return frame_of(np.full((size, size), number, np.uint8), frame_id=number)


def ids(history):
    return [frame.frame_id for frame in history.frames]


def test_it_keeps_the_last_frames_as_they_were():
    history = FrameHistory(most_frames=3)
    frames = [image(n) for n in range(5)]
    for frame in frames:
        history.add(frame)
        frame.payload[:] = 99  # the stream's buffer is used again
    assert ids(history) == [2, 3, 4]
    assert [int(frame.raw()[0, 0]) for frame in history.frames] == [2, 3, 4]


def test_its_memory_is_bounded_also_when_frames_change_their_size():
    history = FrameHistory(most_frames=100, most_bytes=1000)
    for number in range(50):
        history.add(image(number, 10))
    assert len(history.frames) == 10
    history.add(image(60, 30))
    assert ids(history) == [49, 60]
    history.add(image(61, 40))
    assert ids(history) == [49, 60], "a frame larger than everything allowed is left out"
    history.add(image(62, 10))
    assert ids(history) == [60, 62] and sum(f.payload.nbytes for f in history.frames) <= 1000


def test_a_paused_history_does_not_change():
    history = FrameHistory()
    history.add(image(1))
    history.pause(True)
    history.add(image(2))
    assert ids(history) == [1]
    history.pause(False)
    history.add(image(3))
    assert ids(history) == [1, 3]


def test_it_follows_a_grabber_and_starts_over_with_the_next():
    history, grabber = FrameHistory(), ScriptedGrabber()
    history.attach(grabber)
    grabber.send(image(7))
    until(lambda: ids(history) == [7])
    assert history.detach(5)
    assert ids(history) == [7]
    history.attach(ScriptedGrabber())
    assert ids(history) == []
    assert history.detach(5)


def test_a_frame_that_is_copied_while_the_source_changes_is_not_kept():
    history, first, second = FrameHistory(), ScriptedGrabber(), ScriptedGrabber()
    frame, copied, copying = image(7), threading.Event(), threading.Event()

    class Slow:
        nbytes = frame.nbytes

        def detached(self):
            copying.set()
            assert copied.wait(PATIENCE)
            return frame

    history.attach(first)
    first.send(Slow())
    assert copying.wait(PATIENCE)
    history.attach(second)
    copied.set()
    until(lambda: [thread.name for thread in threading.enumerate()].count("history") == 1)
    assert ids(history) == []
    assert history.detach(PATIENCE)
