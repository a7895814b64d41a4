"""Feature panels without the window."""

import pytest

from fakes import ScriptedGrabber
from panel_harness import PanelHarness, camera_features


@pytest.fixture
def make_panel(qtbot):
    """Makes feature panels without the window, on a made-up camera or on any other."""
    made = []

    def build(grabber=None):
        made.append(PanelHarness(qtbot, grabber or ScriptedGrabber(camera_features())))
        return made[-1]

    yield build
    for panel in made:
        panel.close()
