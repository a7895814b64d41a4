"""Every n-th frame and time-lapse, chosen in the menu *Image*."""

import json
from itertools import pairwise

from PyQt5.QtCore import Qt

from grabbergui.cli import main
from grabbergui.recording.thinning import ALL_FRAMES, Thinning
from patience import allowance


def test_every_third_frame_is_recorded_and_a_cancelled_question_changes_nothing(make_app):
    app = make_app()
    app.connect("sim:?width=64&height=48&fps=30")
    frames, bar = app.program.source_controls.frames_to_record, app.window.recordingBar
    frames.every.trigger()
    frames.question.setIntValue(3)
    frames.question.accept()
    assert frames.thinning == Thinning(every=3) and bar.recordButton.text() == "Record · 1/3"
    frames.lapse.trigger()
    frames.question.reject()
    assert frames.thinning == Thinning(every=3) and frames.every.isChecked()
    bar.kindBox.setCurrentIndex(5)  # images
    app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    source = app.program.open_sources.current
    recordings = app.program.source_controls.recordings
    app.until(lambda: recordings.of(source) is not None and recordings.of(source).progress.frames >= 4)
    assert bar.recordButton.text() == "Stop recording"
    app.qtbot.mouseClick(bar.recordButton, Qt.LeftButton)
    app.until(lambda: recordings.of(source).progress.ended)
    (notes,) = app.preferences.snapshot_folder.rglob("*.jsonl")
    ids = [json.loads(line)["frame_id"] for line in notes.read_text().splitlines()]
    assert {after - before for before, after in pairwise(ids)} == {3}
    frames.all.trigger()
    assert frames.thinning == ALL_FRAMES
    app.until(lambda: bar.recordButton.text() == "Record")


def test_the_command_records_a_time_lapse(tmp_path, capsys):
    out = tmp_path / "run.npy"
    source = "sim:?width=64&height=48&fps=40"
    code = main(["record", source, "--out", str(out), "-n", "3", "--interval", "0.2", "--json"])
    printed = json.loads(capsys.readouterr().out)
    assert code == 0 and printed["frames"] == 3 and 0.38 <= printed["seconds"] < 2 * allowance()
