"""Recordings as the window begins and ends them."""

from grabbergui.models.connection import Connection
from grabbergui.models.recording import Recordings
from grabbergui.recording import RecordingKind
from grabbergui.recording.recorder import RecordingLimits
from patience import PATIENCE, until


def test_a_source_that_is_closed_already_is_not_recorded(tmp_path):
    connection = Connection()
    recordings = Recordings(connection)
    connection.connect_to("sim:?width=64&height=48", start=False)
    source = until(lambda: connection.source if connection.state.connected else None)
    connection.close(source)
    assert connection.wait_closed(PATIENCE)
    recordings.begin(source, tmp_path, next(iter(RecordingKind)), RecordingLimits())
    assert not recordings.runs(source)
    assert list(tmp_path.iterdir()) == []
