"""Events of the camera as rows, and their switches."""

import pytest

from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.grabber import DeviceEvent
from grabbergui.core.uri import SourceUri
from grabbergui.models.camera_events import MOST_EVENTS, CameraEvents
from grabbergui.models.open_source import OpenSource
from patience import until


def choice(name, value, *entries, **more):
    access = AccessMode.READ_WRITE
    entries = tuple(map(EnumEntry, entries))
    return Feature(
        name=name, kind=FeatureKind.ENUMERATION, value=value, access=access, entries=entries, **more
    )


@pytest.fixture
def source():
    made = OpenSource(SourceUri.parse("scripted:"))
    made.grabber = ScriptedGrabber(
        [
            choice("EventSelector", "ExposureEnd", "ExposureEnd"),
            choice("EventNotification", "Off", "Off", "On", selectors=("EventSelector",)),
        ]
    )
    made.load_features()
    yield made
    made.release()
    assert made.worker.close()


def test_events_are_rows_with_values_without_their_own_name(source):
    events = CameraEvents(clock=lambda: 12.3456)
    events.attach(source)
    values = {"EventExposureEndTimestamp": 7, "EventExposureEndFrameID": 3, "EventExposureEnd": 1}
    source.grabber.event_received.emit(DeviceEvent("ExposureEnd", 0x9001, values))
    (event,) = events.events
    assert event.row[1:] == ("ExposureEnd", "Timestamp 7, FrameID 3, EventExposureEnd 1")
    assert event.time_text.endswith(":12.345")
    assert events.since(12.0) == [(12.3456, "ExposureEnd")] and events.since(13.0) == []
    events.clear()
    assert events.events == ()
    events.detach()
    source.grabber.event_received.emit(DeviceEvent("ExposureEnd", 0x9001, values))
    assert events.events == ()


def test_the_oldest_are_dropped_and_still_counted(source):
    events = CameraEvents()
    events.attach(source)
    before = events.count
    for number in range(MOST_EVENTS + 5):
        source.grabber.event_received.emit(DeviceEvent("ExposureEnd", 1, {"N": number}))
    assert len(events.events) == MOST_EVENTS and events.events[0].values == "N 5"
    assert events.count == before + MOST_EVENTS + 5


def test_an_event_is_switched_on_and_a_refusal_is_reported(source):
    events, switches, failures = CameraEvents(), [], []
    events.switches_changed.connect(switches.append)
    events.failed.connect(failures.append)
    events.attach(source)
    events.request_switches()
    until(lambda: switches == [{"ExposureEnd": False}])
    events.switch("ExposureEnd", on=True)
    until(lambda: switches[-1] == {"ExposureEnd": True})
    source.grabber.refusals["EventNotification"] = ValueError
    source.grabber.known["EventNotification"] = choice(
        "EventNotification", "On", "On", selectors=("EventSelector",)
    )
    events.switch("ExposureEnd", on=False)
    until(lambda: failures)
