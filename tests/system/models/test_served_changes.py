"""Changes on a camera that is on a network too: whose they were, and undoing one's own alone."""

import threading
import time

import pytest

from grabbergui import sources
from grabbergui.core.shared import SharedGrabber
from grabbergui.models.change_tracking import CONSEQUENCES, revert
from grabbergui.models.open_source import LinkState
from grabbergui.models.source_opener import SourceOpener
from operator_bench import NETWORK, OPERATOR, UNDO
from patience import PATIENCE

URI = "sim:?width=64&height=64&pixel_format=RGB8"


@pytest.fixture
def served():
    """A camera that is on a network too, and a connection to it as the window makes one."""
    camera = sources.create(URI)
    camera.open()
    link = SourceOpener(lambda uri: SharedGrabber(camera))
    link.connect_to("sim:", start=False)
    deadline = time.monotonic() + PATIENCE
    while link.open_sources.state is not LinkState.OPEN:
        assert time.monotonic() < deadline
        time.sleep(0.005)
    yield camera, link.open_sources.current
    link.open_sources.close_current()
    assert link.open_sources.wait_closed(PATIENCE)
    camera.close()


def noted(source, *wanted):
    deadline = time.monotonic() + PATIENCE
    while not set(wanted) <= {(str(c), c.origin) for c in source.journal.changes}:
        assert time.monotonic() < deadline, source.journal.changes
        time.sleep(0.005)


def test_on_a_served_camera_the_log_distinguishes_operator_and_network(served):
    camera, source = served
    reported = threading.Event()
    source.features.feature_changed.connect(lambda feature: reported.set())
    source.features.watch(["Gain", "Gamma"])
    assert reported.wait(PATIENCE)
    source.features.write("Gain", 3.0)
    noted(source, ("Gain 0 → 3", OPERATOR))
    time.sleep(CONSEQUENCES)  # what comes sooner may be a consequence of the operator's own change
    camera.write_feature("Gamma", 2.0)
    noted(source, ("Gamma 1 → 2", NETWORK))
    assert source.journal.next_text(UNDO) == "Gain 0 → 3"
    source.features.run(lambda: revert(source.tracked_grabber, UNDO))
    noted(source, ("Gain 3 → 0", OPERATOR))
    assert camera.feature("Gamma").value == 2.0


def test_undo_follows_the_waiting_writes(served):
    camera, source = served
    source.features.write("Gain", 3.0)
    source.features.write("Gain", 6.0)
    done = threading.Event()
    source.features.run(lambda: revert(source.tracked_grabber, UNDO), done=lambda problems: done.set())
    assert done.wait(PATIENCE)
    assert camera.feature("Gain").value == 0
