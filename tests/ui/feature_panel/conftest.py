"""The panel on a made-up camera, or on any other."""

import pytest
from panel_harness import PanelHarness, camera_features

from fakes import ScriptedGrabber


@pytest.fixture
def make_panel(qtbot):
    made = []

    def build(grabber=None):
        made.append(PanelHarness(qtbot, grabber or ScriptedGrabber(camera_features())))
        return made[-1]

    yield build
    for panel in made:
        panel.close()
