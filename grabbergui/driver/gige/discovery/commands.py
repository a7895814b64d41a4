"""Commands to the network rather than to an open camera: FORCEIP and ACTION."""

from __future__ import annotations

import contextlib
import logging
import socket
import time
from collections.abc import Iterable, Iterator

from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceStatusError,
    LocalProtocolError,
    RemoteProtocolError,
    SourceNotFoundError,
    UsageError,
)
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.discovery.interfaces import interfaces, readable
from grabbergui.driver.gige.discovery.search import LIMITED_BROADCAST
from grabbergui.driver.gige.gvcp import Ack, CommandCode, status_text
from grabbergui.driver.gige.gvcp_messages import Action, ForceIp

log = logging.getLogger(__name__)

TRIES = 3


def force_ip(command: ForceIp, timeout: float = 1.0) -> str:
    """Give the camera of a MAC an address until it is switched off; return the address that acknowledged.

    The command goes to every network by broadcast, so the camera's present address does not matter. Raises
    UsageError for malformed addresses, SourceNotFoundError if no camera acknowledges within `timeout`
    seconds, DeviceStatusError where the camera refuses.
    """
    try:
        datagram = command.encode(1)
    except LocalProtocolError as error:
        raise UsageError(f"force IP: {error.__cause__}; write e.g. 00:30:53:0a:0b:0c 192.168.0.10") from error
    with _broadcasters() as senders:
        for _ in range(TRIES):
            for sender, broadcast in senders:
                for target in {LIMITED_BROADCAST, broadcast}:
                    with contextlib.suppress(OSError):
                        sender.sendto(datagram, (target, GVCP_PORT))
            answer = _first_ack([sender for sender, _ in senders], CommandCode.FORCEIP, timeout / TRIES)
            if answer is not None:
                return answer
    raise SourceNotFoundError(
        f"no camera with the MAC address {command.mac} acknowledged {command.ip}; it may be switched off,"
        " in use by another application, or behind a router"
    )


def send_action(action: Action, addresses: Iterable[str], timeout: float = 0.5) -> None:
    """Send an action to cameras by address, and wait until each has acknowledged.

    Raises AckTimeoutError naming those that did not, DeviceStatusError for one whose time had passed.
    """
    waiting = set(addresses)
    datagram = action.encode(1)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for ip in sorted(waiting):
            sender.sendto(datagram, (ip, GVCP_PORT))
        deadline = time.monotonic() + timeout
        while waiting and (left := deadline - time.monotonic()) > 0:
            if not readable([sender], left):
                break
            answer = _ack(sender, CommandCode.ACTION)
            if answer is not None:
                waiting.discard(answer)
    if waiting:
        raise AckTimeoutError(
            f"the action was not acknowledged by {', '.join(sorted(waiting))}; check its device key, group"
            " key and group mask there"
        )


@contextlib.contextmanager
def _broadcasters() -> Iterator[list[tuple[socket.socket, str]]]:
    """Open a socket on each interface that can broadcast; give each with its broadcast address."""
    with contextlib.ExitStack() as stack:
        senders = []
        for interface in interfaces():
            sender = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            try:
                sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
                sender.bind((interface.ip, 0))
            except OSError as error:
                log.debug("cannot broadcast on %s: %s", interface.name, error)
                continue
            senders.append((sender, interface.broadcast))
        yield senders


def _first_ack(senders: list[socket.socket], command: CommandCode, timeout: float) -> str | None:
    deadline = time.monotonic() + timeout
    while (left := deadline - time.monotonic()) > 0:
        for sender in readable(senders, left):
            answer = _ack(sender, command)
            if answer is not None:
                return answer
    return None


def _ack(sender: socket.socket, command: CommandCode) -> str | None:
    """Return who acknowledged; None for any other datagram. Raises DeviceStatusError for a refusal."""
    try:
        datagram, (source, _) = sender.recvfrom(2048)
        ack = Ack.decode(datagram)
    except (OSError, RemoteProtocolError) as error:
        log.debug("an answer to %s: %s", command.name, error)
        return None
    if ack.acknowledge != command + 1:
        return None
    if ack.failed:
        raise DeviceStatusError(f"{source} refuses {command.name}: {status_text(ack.status)}", ack.status)
    return str(source)
