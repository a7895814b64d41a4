"""Rigs in the window: a new one from the open cameras, its state, the budget of its link."""

from PyQt5.QtCore import Qt

from grabbergui.core.grabber import DeviceEvent
from grabbergui.models.open_source import LinkState
from grabbergui.rig import rig_file
from grabbergui.rig.overview import BudgetOverview
from grabbergui.rig.ui.rig_dialog import RigDialog

SMALL = "sim:?width=64&height=48&fps=20&exposure=1000"


def events(dialog):
    """Name and values of the events that are listed."""
    rows = map(dialog.eventTable.topLevelItem, range(dialog.eventTable.topLevelItemCount()))
    return [(row.text(1), row.text(2)) for row in rows]


def test_a_new_rig_of_the_open_cameras_is_one_source_with_its_state(make_app, tmp_path, monkeypatch):
    app = make_app()
    program, window = app.program, app.window
    app.connect(f"{SMALL}&serial=A")
    program.opener.open_additional(f"{SMALL}&serial=B")
    app.until(lambda: [each.state for each in program.open_sources.all] == 2 * [LinkState.STREAMING])
    assert not window.actionRig.isEnabled() and "New rig" in window.actionRig.toolTip()
    window.actionNewRig.trigger()
    dialog = program.source_controls.new_rig.dialog
    assert [name for name, _ in dialog.cameras] == ["left", "right"]
    dialog.cameraTable.topLevelItem(1).setText(0, "left")
    dialog.triggerBox.setCurrentIndex(1)
    assert dialog.rateBox.isVisible() and not dialog.leaderBox.isVisible()
    app.qtbot.mouseClick(dialog.saveButton, Qt.LeftButton)
    assert "one name" in dialog.problemLabel.text()
    dialog.cameraTable.topLevelItem(1).setText(0, "right")
    path = tmp_path / "stereo.yaml"
    monkeypatch.setattr(program.files, "to_save", lambda *_: path)
    app.qtbot.mouseClick(dialog.saveButton, Qt.LeftButton)
    entry = rig_file.read(path)
    assert list(entry.cameras) == ["left", "right"] and (entry.trigger.by, entry.trigger.rate) == (
        "software",
        10,
    )
    app.until(lambda: program.open_sources.current.uri.scheme == "rig")
    app.until(lambda: program.open_sources.state is LinkState.STREAMING)
    assert len(program.open_sources.all) == 1, "the rig has the cameras now"

    app.until(window.actionRig.isEnabled)
    window.actionRig.trigger()
    seen = program.source_controls.rig.dialog
    app.until(lambda: seen.setsLabel.text() and not seen.setsLabel.text().startswith("Complete sets: 0"))
    app.until(lambda: len(seen.skewPlace.plot.values("skew")) > 2)
    assert [seen.cameraTable.topLevelItem(row).text(0) for row in (0, 1)] == ["left", "right"]
    app.until(lambda: "no link" in seen.outcomeLabel.text())
    assert not seen.applyButton.isVisible()
    assert seen.leaderBox.count() == 3 and seen.leaderBox.currentIndex() == 0
    seen.leaderBox.setCurrentIndex(2)
    seen.leaderBox.activated[int].emit(2)
    app.grabber.cameras["right"].write_feature("Gain", 3)
    app.until(lambda: app.grabber.leader == "right")
    app.until(lambda: app.grabber.cameras["left"].feature("Gain").value == 3)
    app.until(lambda: seen.leaderBox.currentText() == "right")
    # On a busy computer the cameras miss triggers, too, which are events of their own.
    app.grabber.cameras["left"].event_received.emit(DeviceEvent("Overheated", 9, {"EventOverheatedAt": 71}))
    app.until(lambda: ("left.Overheated", "At 71") in events(seen))
    bar = window.image.triggerBar
    app.until(lambda: bar.isVisible() and bar.repeatBox.isChecked() and bar.sendButton.isVisible())
    app.qtbot.mouseClick(bar.repeatBox, Qt.LeftButton, pos=bar.repeatBox.rect().center())
    app.until(lambda: not app.grabber.repeats_trigger)
    window.actionDisconnect.trigger()
    app.until(lambda: program.source_controls.rig.dialog is None)


def test_the_budget_is_a_table_with_what_it_sets(qtbot):
    dialog = RigDialog()
    qtbot.addWidget(dialog)
    rows = (("camera", "needs", "set"), ("left", "3.0 MB/s", "GevSCPD=700"), ("all", "3.0 MB/s", "2 %"))
    asked = []
    dialog.applyRequested.connect(lambda: asked.append("apply"))
    dialog.setBudget(BudgetOverview(rows, ("left needs more than its cable carries",), {}))
    assert dialog.budgetTable.headerItem().text(1) == "Needs" and dialog.budgetTable.topLevelItemCount() == 2
    assert dialog.budgetTable.topLevelItem(0).text(2) == "GevSCPD=700"
    assert dialog.outcomeLabel.text() == "left needs more than its cable carries"
    assert dialog.outcomeLabel.property("problem") is True
    dialog.setBudget(BudgetOverview(rows, (), {}))
    assert dialog.outcomeLabel.text() == "All frames fit into the link." and not asked
    dialog.applyButton.click()
    assert asked == ["apply"]
