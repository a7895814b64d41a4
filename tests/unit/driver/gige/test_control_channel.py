"""The control channel and the heartbeat, in memory, with time as a number."""

from __future__ import annotations

import struct
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gige_transcripts import lines
from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, RemoteProtocolError
from grabbergui.driver.gige import gvcp
from grabbergui.driver.gige.bootstrap import BootstrapRegister, ControlPrivilege
from grabbergui.driver.gige.control_channel import ControlChannel, ControlTiming, Exchange
from grabbergui.driver.gige.gvcp import Ack, CommandCode, ReadReg, Request, Status, WriteReg
from grabbergui.driver.gige.heartbeat import Heartbeat, Holder, Pulse

READ = ReadReg((BootstrapRegister.CCP,))
WRITE = WriteReg(((0x20030, 1),))


def ack_of(datagram: bytes, payload: bytes = b"\0\0\0\2", status: int = 0) -> bytes:
    header, _ = gvcp.split_command(datagram)
    return Ack(status, header.command + 1, header.req_id, payload).encode()


def run_until(
    channel: ControlChannel, end: float, answer: Callable[[float, bytes], bytes | None]
) -> list[float]:
    """Let time pass from deadline to deadline; when each datagram left."""
    sent = []
    now = 0.0
    while True:
        for datagram in channel.datagrams():
            sent.append(now)
            reply = answer(now, datagram)
            if reply is not None:
                channel.receive(reply, now)
        due = channel.timer()
        if due is None or due > end:
            return sent
        now = max(now, due)
        channel.handle_timer(now)


def test_an_answer_ends_the_exchange() -> None:
    channel = ControlChannel()
    exchange = channel.start(READ, 0.0)
    (datagram,) = channel.datagrams()
    assert datagram == bytes.fromhex("420100800004000100000a00")
    channel.receive(ack_of(datagram), 0.01)
    assert exchange.done and exchange.payload == b"\0\0\0\2"
    assert channel.timer() is None
    channel.cancel(exchange)  # as `control_link` does with each


def test_a_lost_command_is_sent_again_unchanged_and_then_given_up() -> None:
    channel = ControlChannel(ControlTiming(ack_timeout=0.5, tries=3))
    exchange = channel.start(READ, 0.0)
    seen: list[bytes] = []
    assert run_until(channel, 10.0, lambda now, data: seen.append(data)) == [0.0, 0.5, 1.0]
    assert len(set(seen)) == 1, "a retry keeps its req_id"
    assert isinstance(exchange.error, AckTimeoutError)
    assert "READREG at 0xA00" in str(exchange.error) and "3 tries" in str(exchange.error)


def test_a_late_first_answer_counts_for_the_retry() -> None:
    channel = ControlChannel()
    exchange = channel.start(READ, 0.0)
    (first,) = channel.datagrams()
    channel.handle_timer(0.4)
    assert list(channel.datagrams()) == [first]
    channel.receive(ack_of(first), 0.5)
    channel.receive(ack_of(first), 0.6)
    assert exchange.payload is not None and channel.ignored == 1


def test_an_answer_must_match_command_and_id() -> None:
    channel = ControlChannel()
    exchange = channel.start(READ, 0.0)
    for stranger in (
        Ack(0, CommandCode.WRITEREG + 1, exchange.req_id, bytes(4)).encode(),
        Ack(0, CommandCode.READREG + 1, exchange.req_id + 1, bytes(4)).encode(),
        b"\0\0",
    ):
        channel.receive(stranger, 0.1)
    assert not exchange.done and channel.ignored == 2
    malformed = Ack(0, gvcp.PENDING_ACK, exchange.req_id, bytes(2)).encode()
    channel.receive(malformed, 0.1)
    assert not channel.patient and channel.timer() == 0.4


def test_a_refusal_names_command_address_and_status() -> None:
    channel = ControlChannel()
    exchange = channel.start(WRITE, 0.0)
    (datagram,) = channel.datagrams()
    channel.receive(ack_of(datagram, b"", Status.WRITE_PROTECT), 0.1)
    assert isinstance(exchange.error, DeviceStatusError) and exchange.error.status == Status.WRITE_PROTECT
    assert "WRITEREG at 0x20030" in str(exchange.error) and "WRITE_PROTECT (0x8004)" in str(exchange.error)


def test_a_busy_device_is_asked_again() -> None:
    channel = ControlChannel()
    exchange = channel.start(WRITE, 0.0)
    replies = iter([Status.BUSY, Status.BUSY, Status.SUCCESS])
    sent = run_until(channel, 5.0, lambda now, data: ack_of(data, bytes(4), next(replies)))
    assert exchange.payload == bytes(4)
    assert sent == pytest.approx([0.0, 0.02, 0.06]), "after a pause that grows"


def test_a_device_that_stays_busy_is_named_so() -> None:
    channel = ControlChannel()
    exchange = channel.start(WRITE, 0.0)
    sent = run_until(channel, 5.0, lambda now, data: ack_of(data, b"", Status.BUSY))
    assert sent == pytest.approx([0.0, 0.02, 0.06, 0.12])
    assert isinstance(exchange.error, DeviceStatusError) and exchange.error.status == Status.BUSY


def test_a_device_that_asked_for_time_and_is_busy_then_is_asked_again() -> None:
    channel = ControlChannel()
    exchange = channel.start(WRITE, 0.0)
    (datagram,) = channel.datagrams()
    channel.receive(gvcp.encode_pending_ack(1000, exchange.req_id), 0.1)
    channel.receive(ack_of(datagram, b"", Status.BUSY), 0.2)
    assert not channel.patient and channel.timer() == pytest.approx(0.22)
    channel.handle_timer(0.22)
    assert channel.datagrams() == [datagram]


def test_pending_ack_moves_the_deadline_and_stops_the_retries() -> None:
    """Replays the captured pause of 1.2 s: PENDING_ACK, a heartbeat in between, then the answer."""
    conversation = list(lines("viva-pending-ack"))
    start = next(i for i, line in enumerate(conversation) if line.data[2:4] == b"\0\x86")
    command, pending = conversation[start : start + 2]
    answer = next(line for line in conversation[start + 2 :] if line.data[2:4] == b"\0\x87")
    channel = ControlChannel(first_request_id=0x64)
    _, payload = gvcp.split_command(command.data)
    exchange = channel.start(gvcp.WriteMem.decode(payload), 0.0)
    assert list(channel.datagrams()) == [command.data]
    channel.receive(pending.data, 0.0)
    assert channel.patient and channel.timer() == pytest.approx(1.8 + 0.4)
    heartbeat = channel.start(READ, 0.75, urgent=True)
    (beat,) = channel.datagrams()
    channel.receive(ack_of(beat), 0.76)
    assert heartbeat.done and not exchange.done
    channel.handle_timer(1.1)
    assert list(channel.datagrams()) == []
    channel.receive(answer.data, 1.2)
    assert exchange.payload is not None and not channel.patient


def test_endless_patience_is_not_given() -> None:
    channel = ControlChannel(ControlTiming(pending_limit=5.0))
    exchange = channel.start(WRITE, 0.0)
    now = 0.0
    while not exchange.done:
        list(channel.datagrams())
        if now < 60:
            channel.receive(gvcp.encode_pending_ack(1000, exchange.req_id), now)
        now = min(now + 0.9, channel.timer() or now)
        channel.handle_timer(now)
    assert now <= 5.0
    asked = "WRITEREG at 0x20030 was not acknowledged within 5.0 s; the camera had asked for more time"
    assert str(exchange.error) == asked


def test_all_commands_together_wait_hardly_longer_than_one_may_be_postponed() -> None:
    """Whoever answers the first with PENDING_ACK only would answer each of the hundreds of an opening so."""
    channel = ControlChannel(ControlTiming(ack_timeout=0.4, tries=4, pending_limit=5.0))

    def carry_out(request: Request, now: float, *, answer: bool = False) -> float:
        exchange = channel.start(request, now)
        while not exchange.done:
            list(channel.datagrams())
            if answer:
                channel.receive(Ack(0, request.CODE + 1, exchange.req_id, bytes(4)).encode(), now)
            else:
                channel.receive(gvcp.encode_pending_ack(1000, exchange.req_id), now)
                now = min(now + 0.9, channel.timer() or now)
            channel.handle_timer(now)
        assert answer or (isinstance(exchange.error, AckTimeoutError) and exchange.error.postponed)
        return now

    now = carry_out(WRITE, 0.0)
    assert now == 5.0
    for request in (READ, WRITE, READ):
        ended = carry_out(request, now)
        assert ended - now == pytest.approx(1.6), "four tries of 0.4 s"
        now = ended
    assert carry_out(READ, now, answer=True) == now
    assert carry_out(WRITE, now) - now <= 1.6, "it answers reads, but still no write"
    carry_out(WRITE, now, answer=True)
    assert carry_out(WRITE, now) - now == 5.0, "as patient as before, after an answer"


def test_request_ids_skip_zero_and_those_in_use() -> None:
    channel = ControlChannel()
    first = channel.start(READ, 0.0)
    for _ in range(0xFFFE):
        channel.cancel(channel.start(READ, 0.0))
    after = channel.start(READ, 0.0)
    assert first.req_id == 1 and after.req_id == 2


@given(st.lists(st.binary(max_size=32), max_size=20))
def test_no_datagram_crashes_the_channel(datagrams: list[bytes]) -> None:
    channel = ControlChannel()
    exchange = channel.start(READ, 0.0)
    for datagram in datagrams:
        channel.receive(datagram, 0.0)
        channel.receive(b"\0\0\0\x81\0\4\0\1" + datagram, 0.0)
    assert isinstance(exchange, Exchange)


def test_commands_are_sent_one_after_another_in_their_order() -> None:
    channel = ControlChannel()
    first, second, third = (channel.start(request, 0.0) for request in (READ, WRITE, READ))
    (datagram,) = channel.datagrams()
    channel.receive(ack_of(datagram), 0.1)
    assert first.done and not second.done
    channel.cancel(second)
    channel.handle_timer(0.1)
    (datagram,) = channel.datagrams()
    assert gvcp.split_command(datagram)[0].req_id == third.req_id


def test_an_answer_to_a_command_that_was_not_sent_yet_ends_nothing_else() -> None:
    channel = ControlChannel()
    first, second = (channel.start(READ, 0.0) for _ in range(2))
    channel.receive(gvcp.encode_pending_ack(1000, second.req_id), 0.1)
    (datagram,) = channel.datagrams()
    channel.receive(ack_of(datagram), 0.2)
    assert first.done and channel.timer() == pytest.approx(0.1 + 1.0 + 0.4)


def test_the_wait_for_its_turn_does_not_count_as_silence() -> None:
    channel = ControlChannel(ControlTiming(ack_timeout=0.5, tries=2))
    channel.start(READ, 0.0)
    second = channel.start(WRITE, 0.0)
    sent = run_until(channel, 10.0, lambda now, data: None)
    assert sent == [0.0, 0.5, 1.0, 1.5]
    assert isinstance(second.error, AckTimeoutError) and "within 1.0 s" in str(second.error)


def test_an_urgent_read_waits_for_a_write_that_may_be_repeated() -> None:
    """A device answers a repeated command again without executing it only if it is the last one it had."""
    channel = ControlChannel(ControlTiming(ack_timeout=0.5, tries=2))
    written = channel.start(WRITE, 0.0)
    (write,) = channel.datagrams()
    read = channel.start(READ, 0.1, urgent=True)
    release = channel.start(WRITE, 0.1, urgent=True)
    (sent,) = channel.datagrams()
    assert gvcp.split_command(sent)[0].req_id == release.req_id, "a write that is urgent is so"
    channel.handle_timer(0.5)
    assert write in channel.datagrams()
    channel.handle_timer(1.0)
    assert isinstance(written.error, AckTimeoutError)
    following = channel.start(WRITE, 1.1)
    sent = [gvcp.split_command(datagram)[0].req_id for datagram in channel.datagrams()]
    assert sent.index(read.req_id) < sent.index(following.req_id), "writes in a row do not hold it up"


def test_an_urgent_command_is_sent_at_once_and_delays_none() -> None:
    channel = ControlChannel()
    slow = channel.start(READ, 0.0)
    beat = channel.start(READ, 0.0, urgent=True)
    assert len(list(channel.datagrams())) == 2
    channel.cancel(slow)
    after = channel.start(WRITE, 0.1)
    (datagram,) = channel.datagrams()
    channel.receive(ack_of(datagram, bytes(4)), 0.2)
    assert after.done and not beat.done


@pytest.mark.parametrize(
    "message, described",
    [
        (ReadReg((0xA00, 0xA04)), "READREG at 0xA00"),
        (WriteReg(((0xA04, 1), (0xA08, 2))), "WRITEREG at 0xA04"),
        (gvcp.ReadMem(0x200, 8), "READMEM at 0x200"),
        (gvcp.WriteMem(0x204, bytes(4)), "WRITEMEM at 0x204"),
    ],
)
def test_a_command_that_is_not_answered_is_described(message: gvcp.Request, described: str) -> None:
    channel = ControlChannel()
    exchange = channel.start(message, 5.0, ControlTiming(ack_timeout=0.5, tries=1))
    (datagram,) = channel.datagrams()
    assert channel.timer() == 5.5
    channel.handle_timer(5.4)
    assert not exchange.done
    channel.handle_timer(5.5)
    assert str(exchange.error) == f"{described} was not acknowledged within 0.5 s (1 tries)"
    assert channel.timer() is None and channel.datagrams() == []
    channel.receive(ack_of(datagram), 5.6)
    assert channel.ignored == 1


class Driven:
    """A heartbeat on a channel, driven as `control_link` drives both."""

    def __init__(self, *, controlling: bool = True, holder: Holder | None = None) -> None:
        self.channel = ControlChannel()
        self.heartbeat = Heartbeat(self.channel, Pulse(), controlling=controlling, now=0.0, holder=holder)
        self.now = 0.0
        self.beats: list[float] = []

    def run(self, end: float, answer: Callable[[float, bytes], bytes | None]) -> Driven:
        while self.heartbeat.lost is None:
            self.channel.handle_timer(self.now)
            self.heartbeat.handle_timer(self.now)
            for datagram in self.channel.datagrams():
                self.beats.append(self.now)
                reply = answer(self.now, datagram)
                if reply is not None:
                    self.channel.receive(reply, self.now)
            self.heartbeat.handle_timer(self.now)
            timers = [self.channel.timer(), self.heartbeat.timer()]
            due = min((timer for timer in timers if timer is not None), default=end + 1)
            if due > end:
                break
            self.now = due
        return self


def test_the_pulse_is_four_times_as_fast_as_control_expires() -> None:
    assert [Pulse.for_timeout(ms).period for ms in (0, 500, 1000, 3000)] == [0.4, 0.125, 0.25, 0.4]


def test_it_beats_once_a_period_while_answered() -> None:
    driven = Driven().run(4.0, lambda now, data: ack_of(data))
    assert driven.heartbeat.lost is None
    assert (
        driven.beats == pytest.approx([0.4 * beat for beat in range(len(driven.beats))])
        and len(driven.beats) >= 10
    )


def test_silence_is_loss_within_two_seconds() -> None:
    driven = Driven().run(10.0, lambda now, data: ack_of(data) if now < 3.0 else None)
    assert driven.heartbeat.lost == "the camera did not answer for 1.2 s"
    assert driven.now - 3.0 < 2.0
    assert not driven.heartbeat.beating and driven.heartbeat.timer() is None


def test_a_few_lost_datagrams_are_no_loss() -> None:
    count = iter(range(1000))
    driven = Driven().run(10.0, lambda now, data: ack_of(data) if next(count) % 4 == 0 else None)
    assert driven.heartbeat.lost is None


@pytest.mark.parametrize("controlling, lost", [(True, True), (False, False)])
def test_lost_privilege_matters_to_a_controller_only(controlling: bool, lost: bool) -> None:
    driven = Driven(controlling=controlling).run(1.0, lambda now, data: ack_of(data, bytes(4)))
    assert (driven.heartbeat.lost is not None) is lost
    if driven.heartbeat.lost is not None:
        assert "took our control back" in driven.heartbeat.lost and driven.now == 0.0


@pytest.mark.parametrize(
    "privilege, ours",
    [(0, False), (ControlPrivilege.EXCLUSIVE, True), (ControlPrivilege.CONTROL, True), (4, False)],
)
def test_exclusive_control_is_control_and_readiness_to_hand_it_over_is_none(
    privilege: int, ours: bool
) -> None:
    driven = Driven().run(1.0, lambda now, data: ack_of(data, privilege.to_bytes(4, "big")))
    assert (driven.heartbeat.lost is None) is ours


def test_control_in_other_hands_is_loss_although_somebody_has_it() -> None:
    ours, theirs = (5000, 0xC0A80001), (6000, 0xC0A80002)

    def answer(now: float, data: bytes) -> bytes:
        return ack_of(data, struct.pack(">III", ControlPrivilege.CONTROL, *(ours if now < 2.0 else theirs)))

    driven = Driven(holder=ours).run(5.0, answer)
    assert driven.heartbeat.lost == "another application, at 192.168.0.2, took control of the camera"
    assert driven.now - 2.0 < 1.0


def test_a_refused_read_means_that_another_has_it_exclusively() -> None:
    def answer(now: float, data: bytes) -> bytes:
        return Ack(Status.ACCESS_DENIED, CommandCode.READREG + 1, int.from_bytes(data[6:8], "big")).encode()

    driven = Driven(controlling=False).run(5.0, answer)
    assert driven.heartbeat.lost == "another application took exclusive control of the camera"


def test_control_is_kept_while_a_device_takes_its_time_over_a_command() -> None:
    driven = Driven()
    write = driven.channel.start(WRITE, 0.0)
    driven.channel.receive(gvcp.encode_pending_ack(6000, write.req_id), 0.0)
    driven.run(5.0, lambda now, data: ack_of(data) if data[2:4] == b"\0\x80" else None)
    assert len(driven.beats) >= 12 and driven.heartbeat.lost is None and not write.done


def test_a_device_that_asked_for_patience_may_be_silent() -> None:
    driven = Driven()
    write = driven.channel.start(WRITE, 0.0)
    driven.channel.receive(gvcp.encode_pending_ack(6000, write.req_id), 0.0)
    driven.run(5.5, lambda now, data: None)
    assert driven.heartbeat.lost is None
    driven.run(20.0, lambda now, data: None)
    assert driven.heartbeat.lost is not None and isinstance(write.error, AckTimeoutError)


def test_a_write_that_waits_for_its_turn_excuses_no_silence() -> None:
    channel = ControlChannel()
    heartbeat = Heartbeat(channel, Pulse(), controlling=True, now=0.0)
    channel.start(READ, 0.0)
    (first,) = channel.datagrams()
    asked = channel.start(heartbeat.request, 0.1)
    channel.start(WRITE, 0.1)
    channel.receive(ack_of(first), 0.2)
    now = 0.2
    while not asked.done:
        channel.handle_timer(now)
        now = channel.timer() or now
    heartbeat.judge(asked, 1.8)
    assert heartbeat.lost == "the camera did not answer for 1.6 s"


@given(st.binary(max_size=12))
def test_no_payload_crashes_the_heartbeat(payload: bytes) -> None:
    try:
        READ.decode_ack(payload)
    except RemoteProtocolError:
        driven = Driven().run(1.0, lambda now, data: ack_of(data, payload))
        assert driven.heartbeat.lost is None
