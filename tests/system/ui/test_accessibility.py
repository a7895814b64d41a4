"""The window for everybody: names to be read aloud, the Tab key, nothing cut off, sharp on any screen."""

import os
import subprocess
from itertools import pairwise

import pytest
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtGui import QImage
from PyQt5.QtWidgets import (
    QAbstractButton,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QCheckBox,
    QComboBox,
    QDockWidget,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QToolBar,
    QToolButton,
    QWidget,
)

from grabbergui.ui.interface_language import speak
from grabbergui.ui.tab_order import LINE_HEIGHT, reading_order
from grabbergui.ui.widgets.labels import ElidedLabel
from operated_controls import controls, is_qts_own, spoken_name
from patience import PROGRAM
from programs import window_command
from screen_reader import Heard, hear


def full_of_panels(app):
    """The window with everything on show that it has."""
    window = app.window
    window.resize(1600, 1000)
    app.connect("sim:colour?fps=15")
    app.watch()
    app.until(lambda: window.features.watched)
    for dock in window.findChildren(QDockWidget):
        dock.show()
    app.program.opener.open_additional("sim:?fps=15")
    app.until(lambda: len(window.gallery.tiles) == 2)
    window.recordingBar.limitBox.setCurrentIndex(1)
    window.actionPause.trigger()
    app.until(window.image.pauseBar.isVisible)
    window.features.levelBox.setCurrentIndex(2)
    app.until(lambda: settled(window))
    return window


def settled(window):
    """Whether every row on show has its controls."""
    rows = window.features.rows
    return all(
        rows.rows(name) and all(row.editor is not None for row in rows.rows(name))
        for name in window.features.watched
    )


def test_every_control_has_a_name_to_be_read_aloud(app):
    window = full_of_panels(app)
    nameless = set()
    for control in controls(window):
        if not spoken_name(control, window):
            name, of = control.objectName(), control.parent().objectName()
            nameless.add(f"{type(control).__name__} {name} of {of}")
    assert not nameless


def test_the_tab_key_visits_every_control_once_and_comes_round(app):
    window = full_of_panels(app)
    window.activateWindow()
    first = window.sources.addressEdit
    first.setFocus()
    visited = [first]
    for _ in range(500):
        app.qtbot.keyClick(QApplication.focusWidget(), Qt.Key_Tab)
        now = QApplication.focusWidget()
        if now is first:
            break
        assert now not in visited, f"Tab is caught between {visited[-1].objectName()} and {now.objectName()}"
        visited.append(now)
    else:
        pytest.fail("Tab does not come round")
    bar, tiles = window.recordingBar, window.gallery.tiles
    for control in (window.sources.sourceList, window.sources.connectButton, window.features.filterEdit,
                    window.features.levelBox, bar.recordButton, bar.kindBox, bar.limitBox, bar.amountBox,
                    window.image.canvas, window.image.pauseBar.slider, *tiles):  # fmt: skip
        assert control in visited, control.objectName()
    assert not [w for w in visited if not w.isVisible()]
    seen = [dock for dock in window.findChildren(QDockWidget) if any(dock.isAncestorOf(w) for w in visited)]
    assert len(seen) == 3, "sources, features, and the one of the tools that lies on top"


def test_the_tab_key_leaves_every_tool(app):
    window = full_of_panels(app)
    window.activateWindow()
    app.program.open_sources.current.features.write("Gain", 3.0)
    app.until(lambda: window.changes.table.model().rowCount() > 0)
    for dock in (window.histogramDock, window.focusDock, window.profileDock, window.valuesDock,
                 window.changesDock, window.logDock):  # fmt: skip
        dock.show()
        dock.raise_()
        app.until(lambda dock=dock: not dock.visibleRegion().isEmpty())
        reading_order([dock])[0].setFocus()
        for _ in range(20):
            if not dock.isAncestorOf(QApplication.focusWidget()):
                break
            app.qtbot.keyClick(QApplication.focusWidget(), Qt.Key_Tab)
        else:
            pytest.fail(f"Tab stays in {dock.objectName()}, on {QApplication.focusWidget().objectName()}")


def places(panel):
    """Return where the controls of a panel are, in the order of the Tab key."""
    return [widget.mapTo(panel, QPoint(0, widget.height() // 2)) for widget in reading_order([panel])]


def test_the_tab_key_goes_as_one_reads(app):
    window = full_of_panels(app)
    panels = window.sources, window.recordingBar, window.features, *window.favourites.rows.rows("Gain")
    for order in app.settled(lambda: [places(panel) for panel in panels]):
        assert len(order) >= 3
        for before, after in pairwise(order):
            lower = after.y() > before.y() - LINE_HEIGHT
            assert lower and (after.x() > before.x() or after.y() >= before.y() + LINE_HEIGHT - 1)


def test_back_tab_goes_the_same_way_back(app):
    window = full_of_panels(app)
    window.activateWindow()
    window.sources.addressEdit.setFocus()
    way = []
    for _ in range(12):
        way.append(QApplication.focusWidget())
        app.qtbot.keyClick(QApplication.focusWidget(), Qt.Key_Tab)
    for expected in reversed(way):
        app.qtbot.keyClick(QApplication.focusWidget(), Qt.Key_Backtab)
        assert QApplication.focusWidget() is expected


def cut_off(window):
    """Texts that do not fit the place they have."""
    behind = [dock for dock in window.findChildren(QDockWidget) if dock.visibleRegion().isEmpty()]
    for widget in window.findChildren(QWidget):
        if not widget.isVisible() or widget.window() is not window or is_qts_own(widget):
            continue
        if any(dock.isAncestorOf(widget) for dock in behind):
            continue  # it is laid out when it comes to the front
        where = f"{type(widget).__name__} {widget.objectName()}"
        if isinstance(widget, QLabel) and not isinstance(widget, ElidedLabel) and widget.text():
            if widget.wordWrap():
                if widget.heightForWidth(widget.width()) > widget.height() + 2:
                    yield where, widget.text()
            elif widget.sizeHint().width() > widget.width() + 1:
                yield where, widget.text()
        elif isinstance(widget, (QAbstractButton, QCheckBox)) and widget.text():
            elides = type(widget).__name__ == "_Header"  # a section's: it shortens its title itself
            if widget.sizeHint().width() > widget.width() + 1 and not elides:
                yield where, widget.text()


@pytest.mark.parametrize("language", ["en", "es"])
def test_no_text_is_cut_off(qapp, request, language):
    speak(qapp, language)
    request.addfinalizer(lambda: speak(qapp, "en"))
    app = request.getfixturevalue("app")
    window, cut = full_of_panels(app), set()
    for size in ((1280, 800), (1366, 768)):
        window.resize(*size)
        assert (window.width(), window.height()) == size, "the window needs more room than it has"
        for dock in window.findChildren(QDockWidget):  # those that lie over each other, one by one
            dock.raise_()
            app.qtbot.wait(30)
            once = set(cut_off(window))
            app.qtbot.wait(50)  # a figure that has just grown gets its room in the next turn
            twice = {where for where, _ in cut_off(window)}
            cut |= {(where, text) for where, text in once if where in twice}
    assert not cut


def test_the_tool_bar_has_room_for_all_of_its_buttons(app):
    bar = app.window.findChild(QToolBar, "toolBar")
    app.qtbot.wait(50)
    for action in bar.actions():
        button = bar.widgetForAction(action)
        assert button.isVisible(), action.text()


@pytest.mark.parametrize("scale", ["1.5", "2"])
def test_on_a_fine_screen_all_is_larger_and_sharp(tmp_path, scale):
    script = tmp_path / "script.py"
    script.write_text("""
from PyQt5.QtGui import QImage
app.patience = 60
app.window.resize(1200, 760)
app.open("sim:?width=640&height=480&fps=10&test_pattern=GreyHorizontalRamp")
app.until(lambda: app.window.image.canvas.imageSize == (640, 480))
app.window.actionOneToOne.trigger()
app.wait_for_frames(5)
app.wait(0.5)
canvas = app.window.image.canvas
assert abs(canvas.zoom - 1) < 0.01, canvas.zoom
app.window.actionStop.trigger()
app.until(app.window.actionStart.isEnabled)
app.wait(0.5)
shown = canvas.grab().toImage().convertToFormat(QImage.Format_Grayscale8)
raw = app.program.image.frame.raw()
place = canvas.frameToView(320, 240)
ratio = canvas.devicePixelRatioF()
x, y = round(place.x() * ratio), round(place.y() * ratio)
same = sum(
    abs(shown.pixelColor(x + dx, y + dy).red() - int(raw[240 + dy, 320 + dx])) <= 2
    for dx in range(-40, 40) for dy in range(-40, 40)
)
assert same == 6400, f"{same} of 6400 pixels are the frame's own"
app.screenshot("window.png")
""")
    environment = {**os.environ, "HOME": str(tmp_path), "QT_SCALE_FACTOR": scale}
    environment.pop("QT_QPA_PLATFORM", None)
    done = subprocess.run(
        window_command("--script", str(script)),
        capture_output=True,
        text=True,
        timeout=PROGRAM,
        env=environment,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    image = QImage(str(tmp_path / "window.png"))
    assert (image.width(), image.height()) == (1200 * float(scale), 760 * float(scale))


ROLES_OF = (
    (QAbstractSpinBox, {"spin box"}),
    (QCheckBox, {"check box"}),
    (QToolButton, {"push button", "button menu", "check box", "button drop-down"}),
    (QPushButton, {"push button", "button menu", "check box", "button drop-down"}),
    (QComboBox, {"combo box"}),
    (QAbstractSlider, {"slider"}),
    (QLineEdit, {"editable text"}),
    (QPlainTextEdit, {"editable text"}),
)
"What each kind of control must be to a screen reader."


def test_a_screen_reader_hears_a_name_and_a_role_of_every_control(app):
    window = full_of_panels(app)
    wrong, heard = set(), 0
    for control in controls(window):
        said, name = hear(control), f"{type(control).__name__} {control.objectName()}"
        roles = next((roles for kind, roles in ROLES_OF if isinstance(control, kind)), None)
        heard += 1
        if said is None or not said.name.strip() or (roles is not None and said.role not in roles):
            wrong.add((name, said))
    assert heard > 60
    assert not wrong


def test_a_screen_reader_hears_what_a_control_of_the_camera_is_called(app):
    app.connect("sim:colour?fps=15")
    row = app.window.favourites.rows.rows("ExposureTime")[0]
    app.until(lambda: row.editor is not None and row.auto is not None and row.auto.isEnabled())
    assert hear(row.editor.field) == Heard("Exposure Time", "spin box")
    assert hear(row.editor.slider()) == Heard("Exposure Time", "slider")
    assert hear(row.auto).name == "Exposure Auto"
