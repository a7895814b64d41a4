"""Entries of an enumeration, chosen from a list."""

from dataclasses import replace

from PyQt5.QtCore import Qt
from sample_features import MODE, K, feature

from grabbergui.core.features import EnumEntry

FORMATS = [f"{colour}{bits}" for colour in ("Mono", "BayerRG", "RGB") for bits in (8, 10, 12, "12p", 16)]
FORMAT = feature(K.ENUMERATION, "Mono8", entries=tuple(EnumEntry(name) for name in FORMATS))


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


def test_a_long_list_is_searched_by_any_part_of_a_name(take, qtbot):
    hand = take(FORMAT)
    for bits in (10, 12):  # entries come and go with other features: it is still one list
        fewer = tuple(replace(entry, available=str(bits) not in entry.name) for entry in FORMAT.entries)
        hand.editor.setFeature(replace(FORMAT, entries=fewer))
    hand.editor.setFeature(FORMAT)
    combo = hand.editor.combo
    assert combo.currentText() == "Mono8"
    line = combo.lineEdit()
    qtbot.keyClick(line, "a", Qt.ControlModifier)
    qtbot.keyClicks(line, "rg12")
    found = combo.completer().completionModel()
    shown = [found.index(row, 0).data() for row in range(found.rowCount())]
    assert shown == ["BayerRG12", "BayerRG12p"]
    qtbot.keyClick(line, Qt.Key_Return)
    assert (hand.values, combo.currentText()) == ([], "Mono8"), "two entries match: neither is meant"
    qtbot.keyClick(line, "a", Qt.ControlModifier)
    qtbot.keyClicks(line, "rg12p")
    qtbot.keyClick(line, Qt.Key_Return)
    assert (hand.values, combo.currentText()) == (["BayerRG12p"], "BayerRG12p")
    assert not take(MODE).editor.combo.isEditable()
