"""The button of an automatic mode: it asks, and only the camera's answer lights it."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QCursor
from sample_features import AUTO, A, K, feature

from grabbergui.core.features import EnumEntry
from grabbergui.ui.editors.choice_editor import AutoButton


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
