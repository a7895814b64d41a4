"""The message channel: a socket on which the device sends its events."""

from __future__ import annotations

import logging
import socket
import threading
from collections import deque
from collections.abc import Callable

from grabbergui.core.errors import GrabberError, RemoteProtocolError, TransportError
from grabbergui.driver.gige.bootstrap import PORT_MASK, BootstrapRegister, MessageCapability, ip_number
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.gige.gvcp import (
    FLAG_ACK_REQUIRED,
    MAX_PAYLOAD,
    Ack,
    CommandCode,
    Status,
    split_command,
)
from grabbergui.driver.gige.gvcp_messages import Event
from grabbergui.driver.gige.interfaces import Interface, leave_through

log = logging.getLogger(__name__)

IDLE_WAIT = 0.2
"Seconds after which the thread checks whether it should end."
REMEMBERED = 64
"Number of request ids kept to recognise repeated messages."


class MessageInbox:
    """Turns messages into acknowledges and events. No I/O."""

    def __init__(self) -> None:
        self.ignored = 0
        "Malformed or foreign datagrams."
        self.repeated = 0
        "Messages received again because their acknowledge was lost."
        self._received: deque[int] = deque(maxlen=REMEMBERED)

    def receive(self, datagram: bytes) -> tuple[bytes, tuple[Event, ...]]:
        """Return the acknowledge to send (empty if none is required) and the new events."""
        try:
            header, payload = split_command(datagram)
            if header.command not in (CommandCode.EVENT, CommandCode.EVENTDATA):
                raise RemoteProtocolError(f"command 0x{header.command:04X} on the message channel")
            if len(payload) > MAX_PAYLOAD:  # its events could not be passed on
                raise RemoteProtocolError(f"GVCP event of {len(payload)} bytes, at most {MAX_PAYLOAD} fit")
            events = Event.decode_all(header.command, payload, header.flags)
        except RemoteProtocolError as error:
            self.ignored += 1
            log.debug("message channel: %s", error)
            return b"", ()
        wanted = header.flags & FLAG_ACK_REQUIRED
        ack = Ack(Status.SUCCESS, header.command + 1, header.req_id).encode() if wanted else b""
        # A camera repeats only messages that require an acknowledge.
        if wanted and header.req_id in self._received:
            self.repeated += 1
            return ack, ()
        self._received.append(header.req_id)
        return ack, events


class MessageChannel:
    """Receives the events of one device; calls `on_event`, which must not wait, on its own thread."""

    def __init__(
        self,
        memory: DeviceMemory,
        device_ip: str,
        interface: Interface,
        on_event: Callable[[int, bytes], None],
    ) -> None:
        """Open a socket on an interface and write its address to the device.

        Raises TransportError, or as writes do.
        """
        self.inbox = MessageInbox()
        self._memory = memory
        self._device_ip = device_ip
        self._on_event = on_event
        self._closing = False
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.settimeout(IDLE_WAIT)
            self._socket.bind((interface.ip, 0))
            leave_through(self._socket, interface)
            self._open(interface.ip)
        except OSError as error:
            self._socket.close()
            raise TransportError(f"no socket for events on {interface.ip}: {error}") from error
        except BaseException:
            self._socket.close()
            raise
        self._thread = threading.Thread(target=self._run, name="gige-messages", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """The host's UDP port for messages."""
        return int(self._socket.getsockname()[1])

    def close(self) -> None:
        """Close the channel in the device and end the thread. Called once; never raises."""
        try:
            self._memory.write_register(BootstrapRegister.MCP, 0)
        except GrabberError as error:
            log.info("closing the message channel: %s", error)
        self.abandon()

    def abandon(self) -> None:
        """End the thread without a command to the device, for a device that is lost."""
        self._closing = True
        if self._thread is not threading.current_thread():
            self._thread.join()
        self._socket.close()

    def _open(self, local_ip: str) -> None:
        memory = self._memory
        memory.write_optional(BootstrapRegister.MCDA, ip_number(local_ip))
        if not memory.write_optional(BootstrapRegister.MCP, self._socket.getsockname()[1]):
            log.warning("the camera opens no message channel, so its events do not arrive")
        if memory.read_optional(BootstrapRegister.MESSAGE_CAPABILITY) & MessageCapability.SOURCE_PORT:
            source_port = memory.read_optional(BootstrapRegister.MCSP) & PORT_MASK
            if source_port:
                # A datagram to the device's source port opens a stateful firewall for its messages.
                self._socket.sendto(b"", (self._device_ip, source_port))

    def _run(self) -> None:
        while not self._closing:
            try:
                datagram, source = self._socket.recvfrom(2048)
            except TimeoutError:
                continue
            except OSError as error:
                log.debug("message channel: %s", error)
                continue
            if source[0] == self._device_ip:
                self._take(datagram, source)
            else:
                self.inbox.ignored += 1

    def _take(self, datagram: bytes, source: tuple[str, int]) -> None:
        ack, events = self.inbox.receive(datagram)
        if ack:
            try:
                self._socket.sendto(ack, source)
            except OSError as error:
                log.debug("acknowledging an event: %s", error)
        for event in events:
            # GenApi's adapter needs whole messages: make one for each event.
            self._on_event(event.event_id, event.encode(1, ack_required=False))
