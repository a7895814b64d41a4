"""A newcomer's first day, with mouse and keys only, each test from a first start.

Nothing is known but what the window shows: texts of buttons and menus, and where they are.
"""

import time

import pytest
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt, QTimer
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QApplication, QFileDialog, QLabel, QLineEdit, QMenu, QPushButton, QToolButton

from grabbergui.models.open_source import LinkState
from grabbergui.sources import discover_kind
from grabbergui.ui.run.window import first_sources
from grabbergui.ui.views.settings_dialogs import SettingsReport
from grabbergui.ui.widgets.source_cards import SOURCE_ROLE
from patience import allowance


class Newcomer:
    """Sees what is on the screen and touches it."""

    def __init__(self, app):
        self.app = app
        self.window = app.window
        self.qtbot = app.qtbot
        self.until = app.until

    def reads(self, text):
        """Whether a text that can be seen holds this."""
        labels = [label for label in self.window.findChildren(QLabel) if label.isVisible()]
        return any(text.lower() in label.text().lower() for label in labels)

    def button(self, text):
        """The button that can be seen and says this."""
        buttons = [*self.window.findChildren(QToolButton), *self.window.findChildren(QPushButton)]
        seen = [b for b in buttons if b.isVisible() and b.text().replace("&", "").rstrip("…") == text]
        assert len(seen) == 1, f"{len(seen)} buttons say {text}"
        return seen[0]

    def frame(self):
        """A frame of now, as the camera sends it."""
        before = self.app.program.image.frame
        self.until(lambda: self.app.program.image.frame is not before)
        return self.app.program.image.frame

    def brightness(self):
        return float(self.frame().rgb().mean())

    def row(self, name, rows=None):
        """The controls of a feature that can be seen."""
        rows = rows or self.window.favourites.rows
        self.until(lambda: any(row.isVisible() and row.editor is not None for row in rows.rows(name)))
        return next(row for row in rows.rows(name) if row.isVisible())

    def press(self, text):
        button = self.button(text)
        self.until(button.isEnabled)
        self.qtbot.mouseClick(button, Qt.LeftButton)

    def choose_in_menu(self, title, text):
        """Open a menu of the window by mouse and click on one of its lines."""
        bar = self.window.menuBar()
        top = next(a for a in bar.actions() if a.text().replace("&", "") == title)
        self.qtbot.mouseClick(bar, Qt.LeftButton, pos=bar.actionGeometry(top).center())
        self.until(lambda: isinstance(QApplication.activePopupWidget(), QMenu))
        menu = top.menu()
        line = next(a for a in menu.actions() if a.text().replace("&", "").rstrip("…") == text)
        assert line.isEnabled()
        self.qtbot.mouseClick(menu, Qt.LeftButton, pos=menu.actionGeometry(line).center())

    def drag(self, widget, first, last):
        self.qtbot.mousePress(widget, Qt.LeftButton, pos=first)
        for step in range(1, 5):
            place = QPointF(first + (last - first) * step / 4)  # QTest's own moves hold no button
            QApplication.sendEvent(
                widget, QMouseEvent(QEvent.MouseMove, place, Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
            )
        self.qtbot.mouseRelease(widget, Qt.LeftButton, pos=last)

    def drag_slider(self, name, share):
        """Take a control's handle to a share of its way."""
        slider = self.row(name).editor.slider()
        self.until(slider.isEnabled)
        y, width = slider.height() // 2, slider.width()
        now = (slider.value() - slider.minimum()) / (slider.maximum() - slider.minimum())
        self.drag(slider, QPoint(round(10 + now * (width - 20)), y), QPoint(round(share * width), y))

    def name_file(self, path):
        """Type a path into the next dialog for files, and press Enter."""

        def answer():
            dialog = QApplication.activeModalWidget()
            if not isinstance(dialog, QFileDialog):
                QTimer.singleShot(20, answer)
                return
            edit = dialog.findChild(QLineEdit, "fileNameEdit")
            edit.clear()
            self.qtbot.keyClicks(edit, str(path))
            self.qtbot.keyClick(edit, Qt.Key_Return)

        QTimer.singleShot(0, answer)


@pytest.fixture
def newcomer(app, monkeypatch):
    # Other tests simulate cameras on this machine's network at the same time.
    monkeypatch.setattr(
        app.program.source_controls.source_list, "_discover", lambda seconds: discover_kind("sim", seconds)
    )
    app.program.begin(*first_sources(None, app.preferences))
    app.until(lambda: app.program.open_sources.state is LinkState.STREAMING)
    app.watch()
    return Newcomer(app)


def listed(newcomer):
    sources = newcomer.window.sources.sourceList
    return [sources.item(row).data(SOURCE_ROLE) for row in range(sources.count())]


def test_the_simulated_camera_is_there_and_is_found_again(newcomer):
    window = newcomer.window
    newcomer.until(lambda: any("Simulated" in s.info.model and s.connected for s in listed(newcomer)))
    newcomer.until(lambda: newcomer.reads("Live"))
    assert newcomer.reads("a real camera appears here"), "how to find a real one is said"
    newcomer.press("Disconnect")
    newcomer.until(lambda: newcomer.reads("Nothing is connected"))
    assert newcomer.reads("choose one of the sources")
    sources = window.sources.sourceList
    newcomer.until(lambda: any(source.info.uri == "sim:" for source in listed(newcomer)))
    row = next(i for i, source in enumerate(listed(newcomer)) if source.info.uri == "sim:")
    place = sources.visualItemRect(sources.item(row)).center()
    newcomer.qtbot.mouseClick(sources.viewport(), Qt.LeftButton, pos=place)
    newcomer.press("Connect")
    newcomer.until(lambda: newcomer.reads("Live"))
    newcomer.app.watch()


def test_the_hint_about_real_cameras_goes_once_one_is_listed(newcomer):
    newcomer.until(lambda: newcomer.reads("a real camera appears here"))
    newcomer.app.program.source_controls.source_list.add("gige:192.0.2.7")
    newcomer.until(lambda: not newcomer.reads("a real camera appears here"))
    newcomer.app.program.source_controls.source_list.remove("gige:192.0.2.7")
    newcomer.until(lambda: newcomer.reads("a real camera appears here"))


def test_the_image_is_made_brighter(newcomer):
    before = newcomer.brightness()
    assert newcomer.reads("Exposure") and newcomer.reads("Gain")
    newcomer.drag_slider("ExposureTime", 0.9)
    newcomer.until(lambda: newcomer.brightness() > 1.3 * before)
    assert not newcomer.app.errors


def test_the_white_balance_is_set(newcomer):
    def cast():
        """By how much the colours' means differ on what is grey: the dial of black and white rays."""
        red, green, blue = newcomer.frame().rgb()[200:700, :400].reshape(-1, 3).mean(axis=0)
        return max(abs(red - green), abs(blue - green)) / green

    newcomer.app.grabber.write_feature("BalanceRatio", 1.0)  # as under another lamp
    newcomer.until(lambda: cast() > 0.2)
    before = cast()
    newcomer.qtbot.mouseClick(newcomer.window.features.filterEdit, Qt.LeftButton)
    newcomer.qtbot.keyClicks(newcomer.window.features.filterEdit, "white")
    combo = newcomer.row("BalanceWhiteAuto", newcomer.window.features.rows).editor.combo
    newcomer.until(combo.isEnabled)
    newcomer.qtbot.mouseClick(combo, Qt.LeftButton)
    newcomer.until(lambda: QApplication.activePopupWidget() is not None)
    for _ in range(combo.findText("Once") - combo.currentIndex()):
        newcomer.qtbot.keyClick(combo.view(), Qt.Key_Down)
    newcomer.qtbot.keyClick(combo.view(), Qt.Key_Return)
    newcomer.until(lambda: cast() < before / 2)
    newcomer.until(lambda: not newcomer.app.errors)  # a busy machine may have sent no frame for a while


def test_a_region_is_drawn_and_the_whole_sensor_comes_back(newcomer):
    canvas = newcomer.window.image.canvas
    newcomer.press("Region")
    newcomer.until(lambda: newcomer.reads("draw"))
    middle = canvas.viewport().rect().center()
    newcomer.drag(canvas.viewport(), middle - QPoint(100, 80), middle + QPoint(100, 80))
    newcomer.until(lambda: newcomer.frame().width < 600)
    assert newcomer.frame().height < 600
    newcomer.press("Full sensor")
    newcomer.until(lambda: newcomer.frame().width > 1224)
    assert not newcomer.app.errors


def test_settings_are_saved_and_come_back(newcomer, tmp_path):
    exposure = newcomer.app.grabber.feature("ExposureTime").value
    path = tmp_path / "mine.yaml"
    newcomer.name_file(path)
    newcomer.choose_in_menu("Camera", "Save settings")
    newcomer.until(lambda: newcomer.reads("mine.yaml"))
    newcomer.drag_slider("ExposureTime", 0.9)
    seen = []

    def is_brighter_and_settled():  # the last of a drag's writes has come too
        seen.append(newcomer.app.grabber.feature("ExposureTime").value)
        return seen[-1] > 2 * exposure and len(seen) > 20 and len(set(seen[-20:])) == 1

    newcomer.until(is_brighter_and_settled)
    newcomer.name_file(path)
    newcomer.choose_in_menu("Camera", "Load settings")
    newcomer.until(lambda: isinstance(QApplication.activeModalWidget(), SettingsReport))
    assert newcomer.app.grabber.feature("ExposureTime").value == pytest.approx(exposure, rel=1e-3)
    newcomer.qtbot.keyClick(QApplication.activeModalWidget(), Qt.Key_Escape)
    newcomer.until(lambda: QApplication.activeModalWidget() is None)


def test_some_seconds_are_recorded_and_played_back(newcomer):
    seconds = 2
    asked = time.monotonic()
    newcomer.press("Record")
    newcomer.until(lambda: newcomer.reads(" frames"))
    begun = time.monotonic()
    newcomer.until(lambda: time.monotonic() - begun > seconds)
    recorded = time.monotonic() - begun
    newcomer.press("Stop recording")
    newcomer.until(newcomer.window.recordingBar.playButton.isVisible)
    ended = time.monotonic()
    newcomer.press("Play")
    newcomer.until(lambda: newcomer.app.program.open_sources.current.uri.scheme == "file")
    newcomer.until(lambda: newcomer.app.program.open_sources.state is LinkState.STREAMING)
    newcomer.app.watch(5)
    played = newcomer.app.grabber
    # From the first frame to the last one, each of which may have come a moment earlier or later.
    assert (
        recorded - min(0.3 * allowance(), seconds / 2)
        <= played.feature("PlaybackDuration").value
        <= ended - asked
    )
    assert played.feature("PlaybackFrameCount").value > 2 * seconds
    assert newcomer.frame().pixel_format.name == "BayerRG8"
