"""Entries of an enumeration, chosen from a list; the button of an automatic mode, which the camera lights."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QCursor

from grabbergui.core.features import EnumEntry
from grabbergui.ui.editors.auto_button import AutoButton
from sample_features import AUTO, MODE, A, K, feature

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


def opened(combo, qtbot):
    """The names in the list that a click on the text of a long list opens."""
    qtbot.mouseClick(combo.lineEdit(), Qt.LeftButton)
    found = combo.completer().completionModel()
    qtbot.waitUntil(combo.completer().popup().isVisible)
    return [found.index(row, 0).data() for row in range(found.rowCount())]


def test_a_click_on_the_text_of_a_long_list_opens_it(take, qtbot):
    hand = take(FORMAT)
    combo = hand.editor.combo
    assert opened(combo, qtbot) == FORMATS
    popup = combo.completer().popup()
    assert popup.currentIndex().data() == "Mono8"
    assert hand.holds == ["start"]
    qtbot.mouseClick(
        popup.viewport(), Qt.LeftButton, pos=popup.visualRect(popup.model().index(3, 0)).center()
    )
    assert hand.values == ["Mono12p"]
    qtbot.waitUntil(lambda: hand.holds == ["start", "finish"])


def test_typing_replaces_the_text_of_a_long_list_and_filters_it(take, qtbot):
    """ "mono" behind "BayerRG8", then Down and Enter, wrote another entry to the camera."""
    hand = take(replace(FORMAT, value="BayerRG8"))
    combo = hand.editor.combo
    opened(combo, qtbot)
    qtbot.keyClicks(combo.lineEdit(), "mono")
    assert combo.lineEdit().text() == "mono"
    popup = combo.completer().popup()
    assert popup.model().rowCount() == 5
    qtbot.keyClick(popup, Qt.Key_Down)
    assert hand.values == []
    qtbot.keyClick(popup, Qt.Key_Down)
    qtbot.keyClick(popup, Qt.Key_Return)
    assert hand.values == ["Mono10"]


@pytest.mark.parametrize("key", [Qt.Key_Up, Qt.Key_Down, Qt.Key_PageUp, Qt.Key_PageDown])
def test_keys_choose_no_entry_of_a_closed_long_list(take, qtbot, key):
    hand = take(replace(FORMAT, value="BayerRG8"))
    combo = hand.editor.combo
    combo.setFocus()
    qtbot.keyClick(combo, key)
    qtbot.waitUntil(combo.completer().popup().isVisible)
    qtbot.keyClick(combo.completer().popup(), Qt.Key_Escape)
    assert (hand.values, combo.currentText()) == ([], "BayerRG8")


def test_a_typed_text_that_is_no_entry_is_dropped(take, qtbot):
    hand = take(replace(FORMAT, value="BayerRG8"))
    combo = hand.editor.combo
    opened(combo, qtbot)
    qtbot.keyClicks(combo.lineEdit(), "xyz")
    qtbot.keyClick(combo.lineEdit(), Qt.Key_Down)
    qtbot.keyClick(combo.lineEdit(), Qt.Key_Return)
    assert (hand.values, combo.currentText()) == ([], "BayerRG8")


def test_a_long_name_shows_its_beginning_and_is_whole_in_the_list(take, qtbot):
    names = [f"PolarizedAngles_0d_45d_90d_135d_{name}" for name in FORMATS]
    polarised = feature(K.ENUMERATION, names[1], entries=tuple(EnumEntry(name) for name in names))
    combo = take(polarised).editor.combo
    combo.resize(120, combo.height())
    assert (combo.currentText(), combo.lineEdit().cursorPosition()) == (names[1], 0)
    combo.showPopup()
    assert combo.view().viewport().width() >= combo.view().sizeHintForColumn(0) > combo.width()
    combo.hidePopup()


@pytest.fixture
def auto(qtbot):
    button = AutoButton()
    qtbot.addWidget(button)
    button.modes = []
    button.modeChosen.connect(button.modes.append)
    button.setFeature(AUTO)
    return button


def test_auto_toggles_between_continuous_and_off(auto):
    assert not auto.isChecked()
    auto.click()
    assert auto.modes == ["Continuous"]
    # Only the camera's answer lights it.
    assert not auto.isChecked()
    auto.setFeature(replace(AUTO, value="Continuous"))
    assert auto.isChecked()
    auto.click()
    assert auto.modes == ["Continuous", "Off"]


def test_once_is_in_the_menu(auto):
    actions = {action.text(): action for action in auto.menu().actions()}
    assert list(actions) == ["Off", "Once", "Continuous"]
    actions["Once"].trigger()
    assert auto.modes == ["Once"]
    auto.setFeature(replace(AUTO, value="Once"))
    assert auto.text() == "Once"
    assert auto.isChecked()


def test_auto_without_continuous_does_it_once(auto):
    auto.setFeature(replace(AUTO, entries=(EnumEntry("Off"), EnumEntry("Once"))))
    auto.click()
    assert auto.modes == ["Once"]


def test_auto_may_be_a_boolean_or_locked(auto):
    auto.setFeature(feature(K.BOOLEAN, False))
    auto.click()
    assert auto.modes == [True]
    auto.setFeature(feature(K.BOOLEAN, True, A.READ_ONLY))
    assert auto.isChecked()
    auto.click()
    assert auto.modes == [True]
    assert "read-only" in auto.toolTip()


def test_it_is_not_lit_once_its_menu_is_closed_with_the_mouse_elsewhere(qtbot):
    button = AutoButton()
    qtbot.addWidget(button)
    button.setFeature(AUTO)
    button.move(200, 200)
    button.show()
    button.setAttribute(Qt.WA_UnderMouse, True)
    QCursor.setPos(0, 0)
    button.menu().popup(button.mapToGlobal(button.rect().bottomLeft()))
    button.menu().close()
    assert not button.underMouse()
