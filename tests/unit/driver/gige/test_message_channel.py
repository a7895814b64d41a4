"""Device events: the message channel's codec and socket, and events in the node map of an open camera."""

from __future__ import annotations

import queue
import struct
import threading
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui import sources
from grabbergui.core.grabber import DeviceEvent
from grabbergui.core.shared import SharedGrabber
from grabbergui.driver.event_delivery import MOST_WAITING, EventDelivery
from grabbergui.driver.gige.gvcp import KEY, Ack, CommandCode, CommandHeader, encode_command
from grabbergui.driver.gige.gvcp_messages import Event
from grabbergui.driver.gige.message_channel import MessageInbox
from patience import PATIENCE, until

EVENT = Event(0x9001, 7, 1234, data=struct.pack(">qq", 42, 1234))


def test_a_message_is_acknowledged_with_its_own_id() -> None:
    ack, events = MessageInbox().receive(EVENT.encode(0x1234))
    assert Ack.decode(ack) == Ack(0, CommandCode.EVENTDATA + 1, 0x1234)
    assert events == (EVENT,)


def test_what_asks_for_no_acknowledge_gets_none_and_is_heard_each_time() -> None:
    inbox = MessageInbox()
    heard = [inbox.receive(EVENT.encode(1, ack_required=False)) for _ in range(2)]
    assert heard == [(b"", (EVENT,))] * 2


def test_a_repeated_message_is_acknowledged_and_not_heard_again() -> None:
    inbox = MessageInbox()
    first, again = (inbox.receive(EVENT.encode(9)) for _ in range(2))
    assert again == (first[0], ()) and inbox.repeated == 1
    assert inbox.receive(EVENT.encode(10))[1] == (EVENT,)


def test_a_message_beyond_gvcps_limit_is_counted_and_ends_nothing() -> None:
    inbox, entry = MessageInbox(), Event(0x9001, data=bytes(600)).entry()
    datagram = CommandHeader.FORMAT.pack(KEY, 1, CommandCode.EVENTDATA, len(entry), 5) + entry
    assert inbox.receive(datagram) == (b"", ()) and inbox.ignored == 1


def test_several_events_of_one_message_are_all_heard() -> None:
    entries = b"".join(Event(number).entry() for number in (3, 4))
    _, events = MessageInbox().receive(encode_command(CommandCode.EVENT, entries, 1))
    assert [event.event_id for event in events] == [3, 4]


@given(st.binary(max_size=80) | st.binary(max_size=60).map(lambda rest: b"\x42\x01\x00\xc2" + rest))
def test_any_datagram_is_heard_or_counted(datagram: bytes) -> None:
    inbox = MessageInbox()
    ack, events = inbox.receive(datagram)
    if inbox.ignored:
        assert (ack, events) == (b"", ())
    else:
        assert datagram[:1] == b"\x42" and datagram[2:4] in (b"\0\xc0", b"\0\xc2")


def test_of_events_beyond_the_limit_the_oldest_are_dropped_with_a_warning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    begun, gate, reported = threading.Event(), threading.Event(), []

    def slow(event_id: int, message: bytes) -> None:
        begun.set()
        gate.wait(PATIENCE)
        reported.append(event_id)

    delivery = EventDelivery(slow, "slow")
    delivery.put(0, b"")
    assert begun.wait(PATIENCE)
    for number in range(1, MOST_WAITING + 11):
        delivery.put(number, b"")
    gate.set()
    until(lambda: reported and reported[-1] == MOST_WAITING + 10)
    assert delivery.dropped == 10 and reported[1] == 11
    assert [record.getMessage() for record in caplog.records] == [
        "slow: more arrive than can be read; the oldest are dropped"
    ]
    delivery.close()
    delivery.put(1, b"")
    assert "slow" not in {thread.name for thread in threading.enumerate()}


def test_a_second_handle_hears_events_too() -> None:
    camera = sources.create("sim:?width=64&height=48")
    camera.open()
    with closing(camera), closing(SharedGrabber(camera)) as handle:
        handle.open()
        reported: queue.Queue[DeviceEvent] = queue.Queue()
        handle.event_received.connect(lambda event: reported.put(event))
        camera.write_feature("EventSelector", "Test")
        camera.write_feature("EventNotification", "On")
        camera.execute("TestEventGenerate")
        assert reported.get(timeout=PATIENCE).name == "Test"
