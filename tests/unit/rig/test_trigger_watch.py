"""How many triggers a watch counts, in whatever order their traces arrive."""

from __future__ import annotations

from fakes import ScriptedGrabber
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.rig.rig_file import TriggerEntry
from grabbergui.rig.settings_undo import UndoableSettings
from grabbergui.rig.trigger_watch import TriggerCounts, TriggerWatch


def frame(number: int) -> Frame:
    return Frame(
        payload=b"\0" * 4,
        width=2,
        height=2,
        pixel_format=by_name("Mono8"),
        frame_id=number,
        timestamp_ns=number * 10**6,
    )


def test_a_frame_that_is_here_before_its_trigger_was_acknowledged_is_not_one_too_many() -> None:
    watch = TriggerWatch(ScriptedGrabber(), TriggerEntry("software"), UndoableSettings(), lambda _: None)
    watch.note_frame(frame(1))
    assert watch.counts() == TriggerCounts(sent=0, accepted=0, missed=0)
    watch.note_sent(10**6, acknowledged=True)
    assert watch.counts() == TriggerCounts(sent=1, accepted=1, missed=0)
