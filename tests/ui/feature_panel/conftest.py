"""The panel on a made-up camera, or on any other."""

import pytest
from panel_desk import Desk, camera_features

from fakes import ScriptedGrabber


@pytest.fixture
def desk(qtbot):
    desks = []

    def build(grabber=None):
        desks.append(Desk(qtbot, grabber or ScriptedGrabber(camera_features())))
        return desks[-1]

    yield build
    for made in desks:
        made.close()
