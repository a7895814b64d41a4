"""Takes the manual's screenshots: each panel of the window, in the current theme.

    grabbergui gui --offscreen --theme dark --script scripts/screenshots.py

They go to the folder that SCREENSHOTS names (docs/images); those of the dark look end in -dark.
"""

# ruff: noqa: F821  (`app` is the window's)

import os
import tempfile
from pathlib import Path

from PyQt5.QtCore import QEvent, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QApplication, QDockWidget, QWidget

from grabbergui.ui.views.help_views import ShortcutsDialog
from grabbergui.ui.widgets.drawing_tool import Purpose

folder = Path(os.environ.get("SCREENSHOTS", "docs/images"))
window, program = app.window, app.program
dark = window.palette().window().color().lightness() < 128
TOOLS_HEIGHT = 230


def take(name: str, widget: QWidget | None = None) -> None:
    """Take one screenshot, after everything has been painted."""
    app.wait(0.2)
    app.screenshot(folder / f"{name}{'-dark' if dark else ''}.png", widget)


def draw(purpose: Purpose, first: tuple[float, float], last: tuple[float, float]) -> None:
    """Drag the mouse between two places, given as fractions of the image."""
    canvas = window.image.canvas
    width, height = canvas.imageSize
    begin, end = (canvas.frameToView(x * width, y * height).toPoint() for x, y in (first, last))
    window.image.draw(purpose)
    viewport = canvas.viewport()
    for kind, place in (
        (QEvent.MouseButtonPress, begin),
        (QEvent.MouseMove, (begin + end) / 2),
        (QEvent.MouseMove, end),
        (QEvent.MouseButtonRelease, end),
    ):
        held = Qt.NoButton if kind == QEvent.MouseButtonRelease else Qt.LeftButton
        button = Qt.NoButton if kind == QEvent.MouseMove else Qt.LeftButton
        QApplication.sendEvent(viewport, QMouseEvent(kind, QPointF(place), button, held, Qt.NoModifier))


def tool(dock: QDockWidget | None) -> None:
    """Show one panel below the image, or none."""
    for other in (window.histogramDock, window.focusDock, window.profileDock, window.valuesDock,
                  window.changesDock, window.logDock):  # fmt: skip
        other.setVisible(other is dock)
    if dock is not None:
        dock.raise_()
        window.resizeDocks([dock], [TOOLS_HEIGHT], Qt.Vertical)
    app.wait(0.25)


window.resize(1440, 900)
program.preferences.snapshot_folder = Path(tempfile.mkdtemp())
app.open("sim:colour")
app.until(lambda: window.features.watched)
app.wait_for_frames(20)
tool(window.histogramDock)
window.histogram.logBox.setChecked(True)
app.until(lambda: "%" in window.histogram.figuresLabel.text())
app.wait(1)
take("overview")
window.histogram.logBox.setChecked(False)
tool(None)
window.resize(1280, 800)
app.wait(0.5)
take("window")
take("sources", window.sourcesDock)
take("features", window.featuresDock)
take("favourites", window.favourites)

tool(window.histogramDock)
app.set("ExposureTime", 20000)
window.actionClipping.trigger()
app.until(lambda: "%" in window.histogram.figuresLabel.text())
take("clipping")
window.actionClipping.trigger()
app.set("ExposureTime", 10000)
app.wait(0.5)
take("histogram", window.histogramDock)

tool(window.focusDock)
draw(Purpose.FOCUS_REGION, (0.05, 0.2), (0.4, 0.75))
app.wait(1.2)
take("focus", window.focusDock)

tool(window.profileDock)
draw(Purpose.PROFILE_LINE, (0.03, 0.9), (0.97, 0.9))
app.until(lambda: window.profile.plot.values("R") is not None)
take("profile", window.profileDock)

tool(window.changesDock)
app.set("Gain", 3)
app.set("ExposureTime", 8000)
take("changes", window.changesDock)

tool(window.valuesDock)
features = program.open_sources.current.features
for name in ("ExposureTime", "DeviceTemperature"):
    program.feature_controls.values.plot(features.description(name))
window.values.spanBox.setCurrentIndex(0)
app.wait(1)
app.set("ExposureTime", 14000)
app.wait(1.5)
app.set("ExposureTime", 8000)
app.wait(1)
take("values", window.valuesDock)
for name in program.feature_controls.values.names:
    program.feature_controls.values.remove(name)
tool(window.logDock)
take("log", window.logDock)
tool(None)

window.actionRegion.trigger()
take("region")
window.image.drawing.cancel()

settings = Path(tempfile.mkdtemp()) / "settings.yaml"
program.feature_controls.settings_files.save(settings)
app.until(settings.exists)
app.set("Gain", 6)
app.set("ExposureTime", 12000)
program.feature_controls.settings_files.compare(settings)
app.until(lambda: program.feature_controls.settings_files.report is not None)
take("settings", program.feature_controls.settings_files.report)
program.feature_controls.settings_files.report.close()
app.set("Gain", 0)
app.set("ExposureTime", 10000)

program.feature_controls.user_sets.show()
app.until(lambda: program.feature_controls.user_sets.dialog is not None)
take("user-sets", program.feature_controls.user_sets.dialog)
program.feature_controls.user_sets.dialog.close()

window.actionCameraFiles.trigger()
files = program.feature_controls.camera_files.dialog
app.until(lambda: files.chosen is not None)
take("files", files)
files.close()

shortcuts = ShortcutsDialog(window.menuBar(), window)
shortcuts.show()
take("shortcuts", shortcuts)
shortcuts.close()

bar = window.recordingBar
bar.limitBox.setCurrentIndex(1)
bar.amountBox.setValue(1.5)
take("recording", bar)
bar.recordButton.click()
app.wait(0.8)
take("recording-runs", bar)
app.until(bar.playButton.isVisible)

program.opener.open_additional("sim:")
program.opener.open_additional("sim:scene?width=608&height=512&fps=10")
window.resize(1440, 1000)
app.until(lambda: len(window.gallery.tiles) == 3)
app.until(lambda: all(tile.thumbnail.image is not None for tile in window.gallery.tiles))
app.until(lambda: not any(tile.stateLabel.text().startswith("0") for tile in window.gallery.tiles))
program.messages.dismiss_all()
app.wait(0.4)
take("gallery")
for source in program.open_sources.all[1:]:
    program.open_sources.close(source)

bar.playButton.click()
app.until(window.image.playbackBar.isVisible)
app.wait(0.6)
take("playback", window.image.playbackBar)

app.open("sim:")
for component in ("Range", "Confidence"):
    app.set("ComponentSelector", component)
    app.set("ComponentEnable", True)
app.until(lambda: window.image.componentTabs.count() == 3)
window.image.componentTabs.setCurrentIndex(1)
app.until(lambda: window.image.scaleBar.isVisible())
take("range", window.image)
window.image.sideBySideBox.setChecked(True)
app.until(lambda: len(window.image.paneArea.panes) == 2)
app.wait(0.5)
take("side-by-side", window.image)

rig = Path(tempfile.mkdtemp()) / "stereo.yaml"
eyes = {name: f"sim:colour?serial={name}&width=608&height=512" for name in ("left", "right")}
rig.write_text(f"cameras: {eyes}\ntrigger: {{by: software, rate: 10}}\n")
app.open(f"rig:{rig}")
app.until(lambda: window.image.componentTabs.count() == 2)
window.image.sideBySideBox.setChecked(True)
app.until(lambda: len(window.image.paneArea.panes) == 1)
app.wait(2)
take("rig", window)
app.open("sim:")

window.actionLookUpTable.trigger()
app.until(lambda: program.feature_controls.lut.dialog is not None)
program.feature_controls.lut.dialog.gammaBox.setValue(0.45)
take("lut", program.feature_controls.lut.dialog)
program.feature_controls.lut.dialog.close()
