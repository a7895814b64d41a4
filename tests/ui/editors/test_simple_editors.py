"""A box that is ticked, a button that is pressed."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import QPoint, Qt
from sample_features import BIT, COMMAND, EXPOSURE, SWITCH, A


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


def test_a_number_that_can_only_be_read_stays_beside_its_unit(take, qtbot):
    label = take(replace(EXPOSURE, access=A.READ_ONLY)).editor.label
    label.setText("10 ms")
    assert label.heightForWidth(20) <= label.fontMetrics().height() + 2 * label.margin() + 1
