"""A camera with an operator at work on it."""

from grabbergui.models.change import Origin
from grabbergui.models.change_journal import ChangeJournal
from grabbergui.models.change_tracking import ChangeTrackingGrabber, revert
from grabbergui.models.undo_steps import STEP_PAUSE, Direction

UNDO, REDO = Direction.UNDO, Direction.REDO
OPERATOR, CAMERA, NETWORK = Origin.OPERATOR, Origin.CAMERA, Origin.NETWORK


class Bench:
    """A grabber, the operator's tracked handle, and a clock."""

    def __init__(self, grabber):
        self.grabber = grabber
        self.now = 100.0
        self.journal = ChangeJournal(clock=lambda: self.now, time_of_day=lambda: 1e9 + self.now)
        self.tracked_grabber = ChangeTrackingGrabber(grabber, self.journal, clock=lambda: self.now)
        self.tracked_grabber.open()  # a camera looks at what moves by itself only while somebody listens

    def value(self, name):
        return self.grabber.feature(name).value

    def write(self, name, value, wait=STEP_PAUSE):
        self.tracked_grabber.write_feature(name, value)
        self.now += wait

    def revert(self, direction, times=1):
        return [problem for _ in range(times) for problem in revert(self.tracked_grabber, direction)]

    @property
    def log(self):
        return [(str(change), change.origin) for change in self.journal.changes]
