"""Entries of an enumeration, chosen from a list."""

from dataclasses import replace

from PyQt5.QtCore import Qt
from sample_features import MODE


def test_an_entry_is_chosen_and_those_not_available_are_grey(take, qtbot):
    hand = take(MODE)
    combo = hand.editor.combo
    assert combo.currentText() == "On"
    assert [combo.model().item(index).isEnabled() for index in range(3)] == [True, True, False]
    combo.setFocus()
    qtbot.keyClick(combo, Qt.Key_Down)
    assert hand.values == ["Off"]
    qtbot.keyClick(combo, Qt.Key_Down)
    assert hand.values == ["Off"]


def test_a_list_that_is_open_holds(take, qtbot):
    hand = take(MODE)
    hand.editor.combo.showPopup()
    assert hand.holds == ["start"]
    hand.editor.combo.hidePopup()
    assert hand.holds == ["start", "finish"]


def test_an_entry_the_camera_did_not_announce_is_still_shown(take):
    hand = take(replace(MODE, value="Secret"))
    assert hand.editor.combo.currentIndex() == -1
    assert hand.editor.combo.placeholderText() == "Secret"
