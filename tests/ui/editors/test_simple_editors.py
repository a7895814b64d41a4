"""A box that is ticked, a button that is pressed."""

import pytest
from PyQt5.QtCore import QPoint, Qt
from sample_features import BIT, COMMAND, SWITCH


@pytest.mark.parametrize(("shown", "value"), [(SWITCH, False), (BIT, 0)])
def test_a_box_is_ticked(take, qtbot, shown, value):
    hand = take(shown)
    assert hand.editor.box.isChecked()
    qtbot.mouseClick(hand.editor.box, Qt.LeftButton, pos=QPoint(6, hand.editor.box.height() // 2))
    assert hand.values == [value]
    assert type(hand.values[0]) is type(value)


def test_a_command_is_run(take, qtbot):
    hand = take(COMMAND)
    qtbot.mouseClick(hand.editor.button, Qt.LeftButton)
    assert hand.values == [None]
