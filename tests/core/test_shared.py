"""A second handle on an open grabber."""

import threading

from test_grabber import ThreeKnobs

from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.shared import SharedGrabber
from patience import PATIENCE


class Plain(ThreeKnobs):
    """Looks at no queue that it gave away."""

    def open_queue(self, depth=2):
        return FrameQueue(depth)


def test_whatever_a_grabber_can_be_asked_is_asked_of_the_one_beneath():
    public = {
        name
        for name, kind in vars(FrameGrabber).items()
        if not name.startswith("_") and (callable(kind) or isinstance(kind, property))
    }
    made_of_the_others = {"features"}

    assert public - made_of_the_others <= set(vars(SharedGrabber))


def test_no_queue_is_forgotten_where_two_threads_open_one_at_a_time():
    handle, opened = SharedGrabber(Plain(DeviceInfo("test:"))), []
    other = threading.Thread(target=lambda: opened.append(handle.open_queue()))

    class Meddling(FrameQueue):
        """Another thread opens a queue just while the list of queues is made anew."""

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
