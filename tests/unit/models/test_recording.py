"""Recordings as the window begins and ends them."""

import threading

from grabbergui.models import recording
from grabbergui.models.recording import Recordings
from grabbergui.models.source_opener import SourceOpener
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import RecordingLimits, create_recorder
from patience import PATIENCE, until


def test_a_source_that_is_closed_already_is_not_recorded(tmp_path):
    connection = SourceOpener()
    recordings = Recordings(connection.open_sources, connection.messages)
    connection.connect_to("sim:?width=64&height=48", start=False)
    source = until(
        lambda: connection.open_sources.current if connection.open_sources.state.connected else None
    )
    connection.open_sources.close(source)
    assert connection.open_sources.wait_closed(PATIENCE)
    recordings.begin(source, tmp_path, next(iter(RecordingKind)), RecordingLimits())
    assert not recordings.runs(source)
    assert list(tmp_path.iterdir()) == []


def test_a_recording_that_begins_while_its_source_is_closed_ends_with_it(tmp_path, monkeypatch):
    connection = SourceOpener()
    recordings = Recordings(connection.open_sources, connection.messages)
    connection.connect_to("sim:?width=64&height=48", start=False)
    source = until(
        lambda: connection.open_sources.current if connection.open_sources.state.connected else None
    )
    closing, begun = threading.Event(), threading.Event()

    def create_late(*arguments):
        assert closing.wait(PATIENCE)
        return create_recorder(*arguments)

    def let_it_begin(_):
        closing.set()
        source.worker.submit(begun.set)
        assert begun.wait(PATIENCE)

    monkeypatch.setattr(recording, "create_recorder", create_late)
    connection.open_sources.ending.connect(let_it_begin)  # after the recordings' own
    recordings.begin(source, tmp_path, next(iter(RecordingKind)), RecordingLimits())
    connection.open_sources.close(source)
    assert recordings.of(source) is None
    assert recordings.close(PATIENCE)
    assert connection.open_sources.wait_closed(PATIENCE)
    assert not any("ended" in message.sentence for message in connection.messages.shown(None))
