"""The bar below the image while a trigger is on."""

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QApplication

from grabbergui.core.settings import SettingKey
from grabbergui.models.triggers import TriggerState
from grabbergui.ui.views.trigger_bar import TriggerBar

BURST = (("TriggerSelector", "FrameBurstStart"),)


@pytest.fixture
def bar(app):
    app.connect("sim:?fps=30&width=64&height=48&exposure=1000")
    return app.window.image.triggerBar


def test_a_trigger_is_sent_repeated_counted_and_switched_off(app, bar):
    app.watch()
    assert not bar.isVisible()
    app.grabber.write_feature("TriggerMode", "On")
    app.until(lambda: bar.isVisible() and bar.sendButton.isVisible())
    app.until(lambda: bar.stateLabel.text() == "Waiting for trigger from Software")
    assert app.window.status.stateLabel.text() == "● Waiting for trigger"
    before = app.grabber.statistics().frames
    app.qtbot.mouseClick(bar.sendButton, Qt.LeftButton)
    app.until(lambda: app.grabber.statistics().frames == before + 1)
    app.until(lambda: bar.countsLabel.text().startswith("1 sent · 1 accepted · 0 missed"))
    bar.periodBox.setValue(20)
    assert app.grabber.statistics().frames == before + 1, "not yet"
    app.qtbot.mouseClick(bar.repeatBox, Qt.LeftButton, pos=bar.repeatBox.rect().center())
    app.until(lambda: app.grabber.statistics().frames > before + 5)
    app.qtbot.mouseClick(bar.repeatBox, Qt.LeftButton, pos=bar.repeatBox.rect().center())
    app.until(lambda: bar.stateLabel.text() == "Waiting for trigger from Software")
    app.qtbot.mouseClick(bar.offButton, Qt.LeftButton)
    app.until(lambda: not bar.isVisible())
    assert app.grabber.feature("TriggerMode").value == "Off"


def test_a_trigger_of_another_selector_shows_with_its_cause(app, bar, monkeypatch):
    monkeypatch.setattr("grabbergui.rig.live_trigger.PATIENCE", 0.0)
    app.grabber.write_setting(SettingKey("TriggerSource", BURST), "Line1")
    app.grabber.write_setting(SettingKey("TriggerMode", BURST), "On")
    assert app.grabber.feature("TriggerSelector").value == "FrameStart"
    app.until(lambda: bar.stateLabel.text() == "Waiting for trigger on Line1")
    app.until(lambda: bar.problemLabel.text().startswith("There is no edge on Line1"))
    assert not bar.sendButton.isVisible() and bar.offButton.isVisible()
    app.qtbot.mouseClick(bar.offButton, Qt.LeftButton)
    app.until(lambda: app.grabber.read_setting(SettingKey("TriggerMode", BURST)).value == "Off")
    app.until(lambda: not bar.isVisible())


def test_the_period_while_repeating_is_a_request_and_setters_are_none(qtbot):
    bar = TriggerBar()
    qtbot.addWidget(bar)
    asked = []
    bar.repeatRequested.connect(asked.append)
    bar.setState(TriggerState("Software", sendable=True, repeating=True, sent=3, accepted=2, missed=1))
    assert bar.countsLabel.text() == "3 sent · 2 accepted · 1 missed" and asked == []
    bar.periodBox.setValue(250)
    assert asked == [0.25]
    bar.repeatBox.click()
    assert asked == [0.25, 0.0]
    bar.periodBox.setValue(100)
    assert asked == [0.25, 0.0], "nothing is sent"
    QApplication.processEvents()
