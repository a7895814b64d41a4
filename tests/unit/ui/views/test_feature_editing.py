"""Features moved in the panel and among the favourites, and what the camera makes of it."""

from PyQt5.QtCore import Qt

from grabbergui.core.errors import GrabberError
from grabbergui.ui.editors.number_editors import FOLLOWING_MS
from panel_harness import A


def test_dragging_a_slider_writes_at_most_60_times_a_second_and_the_last_value(make_panel):
    d = make_panel()
    editor = d.row("Gain").editor
    slider = editor.slider()
    slider.setSliderDown(True)
    for position in range(0, 1000, 10):
        slider.setSliderPosition(position)
        d.qtbot.wait(2)
    slider.setSliderDown(False)
    last = editor.field.text()  # it follows a slider in somebody's hand a moment later
    d.qtbot.waitUntil(lambda: d.grabber.known["Gain"].value == float(last))
    times = [moment for _, _, moment in d.grabber.writes]
    # A single interval may be short, as the machine may be late with the write before it.
    assert (times[-1] - times[0]) / (len(times) - 1) >= 0.016
    assert min(c - a for a, c in zip(times, times[2:], strict=False)) >= 0.016
    assert 2 <= len(times) < 100
    d.qtbot.waitUntil(lambda: d.row("Gain", d.strip).editor.field.text() == last)


def test_while_dragged_nothing_from_outside_moves_the_slider(make_panel):
    d = make_panel()
    slider = d.row("Gain").editor.slider()
    slider.setSliderDown(True)
    position = slider.value()
    d.grabber.set("Gain", 40.0)
    d.qtbot.waitUntil(lambda: d.model.feature("Gain").value == 40.0)
    d.qtbot.wait(30)
    assert slider.value() == position
    slider.setSliderDown(False)
    d.qtbot.waitUntil(lambda: d.row("Gain").editor.field.text() == "40")
    assert d.grabber.writes == []


def test_a_refused_write_is_reported_and_the_widget_shows_the_true_value(make_panel):
    d = make_panel()
    d.row("Gain")
    d.grabber.refusals["Gain"] = GrabberError("Gain=9: the camera answered: busy")
    d.row("Gain").editor.field.stepBy(6)
    d.qtbot.waitUntil(lambda: bool(d.errors))
    assert d.errors == ["Gain=9: the camera answered: busy"]
    d.qtbot.wait(2 * FOLLOWING_MS)
    assert d.row("Gain").editor.field.text() == "6"


def test_what_the_camera_made_of_a_value_is_shown(make_panel):
    d = make_panel()
    d.grabber.on_write = lambda name, value: 16.0
    d.row("Gain").editor.field.stepBy(18)
    d.qtbot.waitUntil(lambda: d.row("Gain").editor.field.text() == "16")
    assert d.written("Gain") == [15.0]
    assert d.errors == []


def test_the_auto_button_beside_a_control(make_panel):
    d = make_panel()
    row = d.row("ExposureTime")
    d.qtbot.waitUntil(lambda: row.auto is not None and row.auto.isEnabled())
    row.auto.click()
    d.qtbot.waitUntil(lambda: d.written("ExposureAuto") == ["Continuous"])
    d.qtbot.waitUntil(row.auto.isChecked)
    d.qtbot.waitUntil(lambda: d.row("ExposureAuto").editor.combo.currentText() == "Continuous")
    assert d.row("ExposureTime", d.strip).auto.isChecked()
    # The camera regulates, and the slider follows.
    before = row.editor.slider().value()
    d.grabber.set("ExposureTime", 5e5)
    d.qtbot.waitUntil(lambda: row.editor.slider().value() > before)
    row.auto.click()
    d.qtbot.waitUntil(lambda: d.written("ExposureAuto") == ["Continuous", "Off"])


def test_a_feature_that_gets_locked_turns_grey_and_comes_back(make_panel):
    d = make_panel()
    row = d.row("Gain")
    d.grabber.set("Gain", access=A.READ_ONLY)
    d.qtbot.waitUntil(lambda: not row.editor.isEnabled())
    assert "read-only" in row.toolTip()
    d.grabber.set("Gain", access=A.READ_WRITE)
    d.qtbot.waitUntil(row.editor.isEnabled)


def test_other_locks_stay_however_the_automatic_mode_is(make_panel):
    d = make_panel()
    row = d.row("ExposureTime")
    d.grabber.set("ExposureTime", access=A.READ_ONLY)
    d.qtbot.waitUntil(lambda: not row.editor.isEnabled())
    d.grabber.set("ExposureAuto", "Continuous", access=A.READ_ONLY)
    d.qtbot.waitUntil(lambda: row.auto is not None and row.auto.isChecked())
    assert not row.editor.isEnabled() and not row.editor.slider().isEnabled()


def test_a_command_is_run(make_panel):
    d = make_panel()
    d.qtbot.mouseClick(d.row("TriggerSoftware").editor.button, Qt.LeftButton)
    d.qtbot.waitUntil(lambda: d.grabber.commands == ["TriggerSoftware"])
    assert d.grabber.writes == []


def test_favourites_are_there_whatever_the_camera_calls_them(make_panel):
    d = make_panel()
    rows = [d.row(name, d.strip) for name in ("ExposureTime", "Gain", "AcquisitionFrameRateAbs")]
    assert [row.title for row in rows] == ["Exposure", "Gain", "Frame rate"]
    assert sorted(rows, key=lambda row: (row.y(), row.x())) == rows
    rows[2].editor.field.stepBy(1)
    d.qtbot.waitUntil(lambda: d.written("AcquisitionFrameRateAbs") == [26])
    d.qtbot.waitUntil(lambda: d.row("AcquisitionFrameRateAbs").editor.field.text() == "26")


def test_a_favourite_of_a_closed_section_is_followed_too(make_panel):
    d = make_panel()
    d.qtbot.mouseClick(d.panel.section("AnalogControl").header, Qt.LeftButton)
    assert "Gain" not in d.panel.watched
    d.grabber.set("Gain", 33.0)
    d.qtbot.waitUntil(lambda: d.row("Gain", d.strip).editor.field.text() == "33")
