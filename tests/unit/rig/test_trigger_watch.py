"""How many triggers a watch counts, in whatever order their traces arrive, and what clocks let it say."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import DeviceEvent
from grabbergui.core.pfnc import by_name
from grabbergui.rig.clock_fit import HostTime
from grabbergui.rig.rig_file import TriggerEntry
from grabbergui.rig.settings_undo import UndoableSettings
from grabbergui.rig.trigger_diagnosis import TriggerCause
from grabbergui.rig.trigger_watch import TriggerCounts, TriggerWatch

MS = 1_000_000
PERIOD, WIDTH = 66 * MS, 4 * MS


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


def choice(name: str, *entries: str, selectors: tuple[str, ...] = ()) -> Feature:
    return Feature(
        name=name,
        kind=FeatureKind.ENUMERATION,
        access=AccessMode.READ_WRITE,
        value=entries[0],
        entries=tuple(map(EnumEntry, entries)),
        selectors=selectors,
    )


def clock(offset: int, uncertainty: int) -> Callable[[int], HostTime | None]:
    return lambda device_ns: HostTime(device_ns + offset, uncertainty)


LATE, EARLY = 2 * MS, -2 * MS


@pytest.mark.parametrize(
    "leader, inverted, cause",
    [
        (clock(LATE, 2 * MS), False, TriggerCause.NONE),
        (clock(EARLY, 2 * MS), False, TriggerCause.NONE),
        (clock(0, 10_000), True, TriggerCause.WRONG_EDGE),
        (clock(LATE, 8 * MS), True, TriggerCause.NONE),
        (lambda _: None, True, TriggerCause.NONE),
    ],
    ids=["late", "early", "known", "known too vaguely", "unknown"],
)
def test_an_edge_is_called_wrong_only_if_the_leaders_clock_is_known_well_enough(
    leader: Callable[[int], HostTime | None], inverted: bool, cause: TriggerCause
) -> None:
    names = ("FrameTriggerMissed", "Line1RisingEdge", "Line1FallingEdge")
    camera = ScriptedGrabber(
        [
            choice("EventSelector", *names),
            choice("EventNotification", "Off", "On", selectors=("EventSelector",)),
            Feature(name="ExposureTime", kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=4000.0),
        ]
    )
    entry = TriggerEntry("line", 15, leader="left", input="Line1")
    watch = TriggerWatch(camera, entry, UndoableSettings(), clock(0, 1000), leader)
    begin, end = ("Falling", "Rising") if inverted else ("Rising", "Falling")
    for pulse in range(1, 13):
        watch.note_sent(pulse * PERIOD, acknowledged=True)
        for at, edge in ((0, begin), (WIDTH, end)):
            stamp = {f"EventLine1{edge}EdgeTimestamp": pulse * PERIOD + at}
            camera.event_received.emit(DeviceEvent(f"Line1{edge}Edge", 0, stamp))
    assert watch.finding().cause is cause
