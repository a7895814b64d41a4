"""Sources side by side that have a zoom each: it outlives that the canvas is cleared for another source."""

import numpy as np
import pytest
from PyQt5.QtCore import QRectF

from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.models.image.components import ShownImage
from grabbergui.ui.views.image_view import ImageView

IMAGE = DisplayImage(np.zeros((240, 320), np.uint8), Region(0, 0, 320, 240))


@pytest.fixture
def view(qtbot):
    """Two sources, "left" in the canvas and "right" in a pane, each with a zoom of its own."""
    view = ImageView()
    qtbot.addWidget(view)
    view.resize(1000, 600)
    view.show()
    view.setSeparateZoom(True)
    view.setImage(IMAGE, 320, 240)
    show(view, "left", "right")
    qtbot.waitUntil(lambda: view.paneArea.panes["right"].height() == view.canvas.height())
    return view


def show(view, current, other):
    view.setSourcesBeside(("left", "right"), current, [ShownImage(None, IMAGE, 320, 240, label=other)])


def test_a_cleared_canvas_leaves_the_panes_where_they_are(view):
    pane = view.paneArea.panes["right"]
    view.canvas.setSeen(QRectF(0.375, 0.375, 0.25, 0.25))
    pane.showPart(QRectF(0.25, 0.25, 0.5, 0.5))
    seen = pane.seen
    view.clear()
    assert pane.seen == seen


@pytest.mark.parametrize("image_first", [False, True])
def test_the_source_that_becomes_current_keeps_its_zoom_in_the_canvas(view, qtbot, image_first):
    view.canvas.setSeen(QRectF(0.375, 0.375, 0.25, 0.25))
    view.paneArea.panes["right"].showPart(QRectF(0.25, 0.25, 0.5, 0.5))
    view.clear()
    if image_first:
        view.setImage(IMAGE, 320, 240)
        show(view, "right", "left")
    else:
        show(view, "right", "left")
        view.setImage(IMAGE, 320, 240)
    left = view.paneArea.panes["left"]
    qtbot.waitUntil(lambda: left.height() == view.canvas.height())
    assert (view.canvas.seen.width(), left.seen.width()) == pytest.approx((0.5, 0.25), abs=0.02)
