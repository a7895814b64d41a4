"""GVCP: every decoder, the control and message channels of a host, and a camera's whole control side."""

from __future__ import annotations

import functools

from fuzz._input import Input, captured, erring, joined, refusing
from grabbergui.driver.gige import gvcp, gvcp_messages
from grabbergui.driver.gige.control_channel import ControlChannel as HostChannel
from grabbergui.driver.gige.identity import ForceIp, Identity
from grabbergui.driver.gige.message_channel import MessageInbox
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.control import ControlResponder as CameraChannel
from grabbergui.driver.sim.memory import RegisterMemory
from grabbergui.driver.sim.model import CameraModel

HOST = ("127.0.0.1", 5000)
OTHER = ("127.0.0.2", 5001)


def seeds() -> list[bytes]:
    """Return captured conversations, for each part."""
    commands, answers, events = captured("C"), captured("S"), captured("E")
    return [
        *(b"\0" + datagram for datagram in (*commands, *answers, *events)),
        b"\1" + joined(answers[:20]),
        b"\2" + joined(events[:20]),
        *(b"\3" + joined(commands[start : start + 20]) for start in range(0, len(commands), 20)),
    ]


def one_input(data: bytes) -> None:
    """Feed the part that the first byte chooses."""
    source = Input(data)
    (_decode, _host, _messages, _camera)[source.number(1) % 4](source)


def _decode(source: Input) -> None:
    datagram = source.rest()
    split = refusing(gvcp.split_command, datagram)
    if split is not None:
        header, payload = split
        for kind in (gvcp.ReadReg, gvcp.WriteReg, gvcp.ReadMem, gvcp.WriteMem):
            request = refusing(kind.decode, payload)
            if request is not None:
                erring(request.payload)
        refusing(gvcp.PacketResend.decode, payload, header.flags)
        refusing(gvcp_messages.Event.decode_all, header.command, payload, header.flags)
        refusing(gvcp_messages.Action.decode, payload, header.flags)
        refusing(ForceIp.decode, payload)
    ack = refusing(gvcp.Ack.decode, datagram)
    if ack is not None:
        refusing(gvcp.ReadReg((0, 4)).decode_ack, ack.payload)
        refusing(gvcp.ReadMem(0, 8).decode_ack, ack.payload)
        refusing(gvcp.decode_pending_ack, ack.payload)
        identity = refusing(Identity.decode, ack.payload)
        if identity is not None and not identity.mac:
            raise AssertionError(identity)


def _host(source: Input) -> None:
    channel, now = HostChannel(), 0.0
    exchanges = [channel.start(gvcp.ReadReg((0xA00,)), now), channel.start(gvcp.WriteReg(((4, 5),)), now)]
    for datagram in source.messages():
        now += 0.1
        channel.receive(datagram, now)
        channel.handle_timer(now)
        list(channel.datagrams())
    while (due := channel.timer()) is not None:
        if due > 1000:
            raise AssertionError(f"waits until {due}")
        channel.handle_timer(due)
        list(channel.datagrams())
    if not all(exchange.done for exchange in exchanges):
        raise AssertionError("an exchange has no end")


def _messages(source: Input) -> None:
    inbox, datagrams = MessageInbox(), list(source.messages())
    for datagram in datagrams:
        ack, events = inbox.receive(datagram)
        for event in events:
            event.encode(1)
        if ack:
            gvcp.Ack.decode(ack)
    if inbox.ignored + inbox.repeated > len(datagrams):
        raise AssertionError(inbox)


@functools.cache
def _simulated() -> tuple[CameraModel, RegisterMemory]:
    model = CameraModel()
    return model, gev.make_bootstrap(model, "127.0.0.9", "255.0.0.0", bytes(6))


def _camera(source: Input) -> None:
    # Made once, as it takes long; what registers hold outlives an input.
    channel = CameraChannel(*_simulated())
    now = 0.0
    for number, datagram in enumerate(source.messages()):
        now += 0.05
        for out in channel.receive(datagram, OTHER if number % 7 == 6 else HOST, now):
            ack = gvcp.Ack.decode(out.datagram)
            if len(ack.payload) > gvcp.MAX_PAYLOAD:
                raise AssertionError(f"acknowledge of {len(ack.payload)} bytes")
        channel.run_deferred()
        channel.poll(now)
    channel.release()
