"""The Help menu: the manual, the doctor, and What's this?"""

import re
import threading

from PyQt5.QtCore import QEvent, QPoint, Qt
from PyQt5.QtGui import QHelpEvent
from PyQt5.QtWidgets import QAbstractButton, QApplication, QDockWidget, QWhatsThis

from grabbergui.core.environment import MANUAL
from grabbergui.doctor.findings import good, note, problem
from grabbergui.driver.twin import report_file
from grabbergui.report import computer
from grabbergui.ui.controllers.help import HelpController


def test_the_manual_opens_and_its_links_lead_to_other_pages(app):
    app.window.actionManual.trigger()
    manual = app.program.help_controls.help.manual
    assert "Find a camera" in manual.text.toPlainText()
    manual.text.anchorClicked.emit(manual.text.source().resolved(type(manual.text.source())("tuning.md")))
    assert (MANUAL / "tuning.md").read_text("utf-8").splitlines()[0].lstrip("# ") in (
        manual.text.toPlainText()
    )
    manual.close()


def test_the_doctor_looks_on_a_thread_of_its_own_and_shows_what_it_finds(app, monkeypatch):
    threads, mended = [], []

    def look():
        threads.append(threading.current_thread().name)
        yield good("the network is <fine>")
        yield problem("no rule", "grabbergui doctor --fix-udev")
        if not mended:
            yield note("buffers are small", "sudo sysctl", lambda: mended.append(1))

    monkeypatch.setattr("grabbergui.doctor.check", look)
    app.window.actionDoctor.trigger()
    doctor = app.program.help_controls.help.doctor
    app.until(lambda: doctor.stateLabel.text() == "1 fault, 1 warning")
    assert threads == ["doctor"]
    assert [row.levelLabel.text() for row in doctor.rows] == ["OK", "Fault", "Warning"]
    app.until(lambda: [row.mendButton.isVisible() for row in doctor.rows] == [False, False, True])
    app.qtbot.mouseClick(doctor.copyButton, Qt.LeftButton)
    text = QApplication.clipboard().text()
    assert "OK: the network is <fine>" in text and "→ grabbergui doctor --fix-udev" in text
    app.qtbot.mouseClick(doctor.rows[2].mendButton, Qt.LeftButton)
    app.until(lambda: doctor.stateLabel.text() == "1 fault")
    assert mended == [1] and len(doctor.rows) == 2, "everything was checked again"
    doctor.close()
    app.until(lambda: app.program.help_controls.help.doctor is None)


def test_whats_this_explains_a_control_by_its_tooltip(app, monkeypatch):
    app.connect()
    app.until(lambda: app.window.features.watched)
    said = []
    monkeypatch.setattr(QWhatsThis, "showText", lambda _, text, widget: said.append(text))
    row = app.window.favourites.rows.rows("Gain")[0]
    app.until(lambda: row.editor is not None)
    app.window.actionWhatsThis.trigger()
    for widget in (
        row.editor.field,
        app.window.toolBar.widgetForAction(app.window.actionStop),
    ):
        asked = QHelpEvent(QEvent.QueryWhatsThis, QPoint(3, 3), QPoint(300, 300))
        assert QApplication.sendEvent(widget, asked) and asked.isAccepted()
        QApplication.sendEvent(widget, QHelpEvent(QEvent.WhatsThis, QPoint(3, 3), QPoint(300, 300)))
    assert "Gain" in said[0] and "dB" in said[0]
    assert said[1].startswith("Stop streaming")
    QWhatsThis.leaveWhatsThisMode()


def test_the_cross_of_each_panel_says_how_to_open_it_again(app):
    docks = app.window.findChildren(QDockWidget)
    crosses = [dock.findChild(QAbstractButton, "qt_dockwidget_closebutton") for dock in docks]
    assert len(crosses) == 8 and all("open it again" in cross.toolTip() for cross in crosses)


def test_other_events_do_not_come_by_but_while_something_is_asked(app, monkeypatch):
    """A filter in Python on all events took a seventh of the GUI thread."""
    window, seen = app.window, []
    look = HelpController.eventFilter
    monkeypatch.setattr(
        HelpController, "eventFilter", lambda self, of, event: seen.append(of) or look(self, of, event)
    )

    def events_of_a_child() -> int:
        del seen[:]
        QApplication.sendEvent(window.toolBar, QEvent(QEvent.UpdateRequest))
        return seen.count(window.toolBar)

    assert events_of_a_child() == 0
    window.actionWhatsThis.trigger()
    assert events_of_a_child() > 0
    QWhatsThis.leaveWhatsThisMode()
    assert events_of_a_child() == 0


def test_a_camera_is_reported_while_it_streams(app, monkeypatch, tmp_path):
    monkeypatch.setattr(computer, "network", lambda: {"interfaces": [], "discovery": []})
    monkeypatch.setattr(computer, "findings", list)
    monkeypatch.setattr("grabbergui.ui.controllers.report.FRAMES", 5)
    app.connect()
    file = tmp_path / "camera.zip"
    monkeypatch.setattr(app.program.files, "to_save", lambda title, name, kinds: file)
    app.window.actionReport.trigger()
    dialog = app.program.help_controls.report.dialog
    save = dialog.saveButton
    assert not save.isEnabled()
    app.until(save.isEnabled)
    text = dialog.text.toPlainText()
    found = re.search(r"(\d+) features", text)
    assert found is not None and int(found[1]) > 100 and "replaced by stand-ins" in text
    dialog.namesBox.setChecked(True)
    assert "AS THEY ARE" in dialog.text.toPlainText()
    assert not file.exists(), "it says what is inside before it is written"
    save.click()
    app.until(file.exists)
    report = report_file.load(file)
    assert report.info.serial == "SIM001" and report.stream.frames and not report.pixels
    assert app.program.help_controls.report.dialog is None
