import numpy as np
import pytest
from PyQt5.QtGui import QImage

from grabbergui.ui.theme import Theme, dress
from grabbergui.ui.widgets.labels import ElidedComboBox

BESIDE_ARROW = 28
"Pixels at the right of a combo box in which its arrow is."


def pixels(box, width):
    """The left `width` pixels of a combo box, (height, width, 4)."""
    box.show()
    image = box.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    whole = image.bits().asarray(image.sizeInBytes())
    return np.array(whole, np.uint8).reshape(image.height(), -1, 4)[:, :width]


@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.DARK])
@pytest.mark.parametrize("text", ["Last 10 seconds", "Until stopped", "ROS 2 messages (MCAP)", "Off"])
def test_a_box_as_wide_as_its_text_needs_shows_it_whole(qtbot, qapp, request, theme, text):
    request.addfinalizer(lambda: qapp.setStyleSheet(""))
    dress(qapp, theme)
    box = ElidedComboBox()
    qtbot.addWidget(box)
    box.addItem(text)
    size = box.sizeHint()
    box.resize(size)
    assert box.shown == text
    narrow = pixels(box, size.width() - BESIDE_ARROW)
    box.resize(2 * size.width(), size.height())
    assert np.array_equal(narrow, pixels(box, size.width() - BESIDE_ARROW)), "the text is cut"


def test_a_narrower_box_shows_dots(qtbot):
    box = ElidedComboBox()
    qtbot.addWidget(box)
    box.addItem("Last 10 seconds")
    box.resize(box.sizeHint().width() - 12, box.sizeHint().height())
    assert box.shown.startswith("Last 10") and box.shown.endswith("…")
