"""A port: a name, a listening socket, and its connections in both directions.

Threads: one accepts, one keeps the name registered, each connection has its own. All public methods may be
called from any thread. `Listener` accepts, `Input` receives, `Output` sends, `Registry` limits both, and
`PortCommands` answers administrative requests.
"""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Callable
from functools import partial
from typing import Final

from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.errors import (
    GrabberError,
    LocalProtocolError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.admin import PortCommands
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.carrier import Carrier
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.framing import new_memory
from grabbergui.net.yarp.os.inputs import Input, Reply, Request
from grabbergui.net.yarp.os.link import Link, report_end, run_all
from grabbergui.net.yarp.os.listener import Listener
from grabbergui.net.yarp.os.multicast import MulticastGroups
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.outputs import Output, connect
from grabbergui.net.yarp.os.port_environment import port_name, port_number, registered_address
from grabbergui.net.yarp.os.registration import Registration
from grabbergui.net.yarp.os.registry import Registry
from grabbergui.net.yarp.os.stranger_log import StrangerLog
from grabbergui.net.yarp.os.target import Target, check_port_name, literal_address
from grabbergui.net.yarp.os.values import Item, Vocab

log = logging.getLogger(__name__)

NO_OUTPUT: Final = "Outputs not allowed"
"""YARP's answer of a port that sends nothing."""

END_SECONDS: Final = 5.0
"""Longest wait for requests in progress when a port closes, all of them together."""

REPORT_SECONDS: Final = 1.0
"""Longest wait for readers of udp when a port closes; one that hangs must not hold up a program's end."""

Handler = Callable[[Request], Reply]
"""Answers a request, on the thread of its connection."""


class Port:
    """A YARP port. `OutputPort`, `InputPort` and `RpcServer` are the kinds to use."""

    sends = True
    "Whether readers may be connected to it."
    plug_ins: frozenset[str] = frozenset()
    "Plug-ins whose work it does for senders that ask for it with `+recv.…`."
    limit = 16 << 20
    "Size of the longest message accepted, in bytes."
    obeys_environment = True
    "Whether YARP's environment variables change its name and TCP port."

    def __init__(
        self,
        name: str,
        names: NameClient | None = None,
        *,
        handler: Handler | None = None,
        bind: str = "",
        port: int = 0,
        allowed: AllowedAddresses = EVERYBODY,
    ) -> None:
        """Make a port; `open` starts it. YARP's environment variables may change `name` and `port`.

        `handler` answers requests, several at once; without it they get no reply.

        Without `names` it is reached as `tcp://HOST:PORT/` only. `bind` is the address to listen at; by
        default the one from which the name server is reached, or loopback without a name server. Peers that
        are not `allowed` are neither answered nor sent to.
        """
        if self.obeys_environment:
            name, port = port_name(name), port_number(name) or port
        self.name = check_port_name(name)
        self.properties: dict[str, Item] = {}
        self.contact = Contact(self.name, "", 0)
        "Address on which the port listens, once open."
        self.key = names.key if names else None
        self.commands = PortCommands(self, images=self.sends)
        "Answers administrative requests."
        self._names = names
        self._handler = handler
        self._allowed = allowed
        self._strangers = StrangerLog(self.name)
        self._refusals = StrangerLog(self.name, level=logging.INFO)
        self._address = (bind, port)
        self._registry = Registry(self._strangers)
        self._groups = MulticastGroups(self.name, names)
        self._listener = Listener(self.name, self._welcome, self._registry.free_resources)
        self._registration: Registration | None = None

    def open(self) -> None:
        """Listen and register. Leaves nothing open if it raises SourceUnavailableError or TransportError."""
        bind, host = self._addresses()
        try:
            self.contact = Contact(self.name, host, self._listener.open((bind, self._address[1])))
        except TransportError as error:
            raise TransportError(f"{self.name} {error}") from error
        try:
            self._prepare()
        except GrabberError:
            self._listener.close()
            self._registration = None
            raise
        self._registry.reopen()
        self._listener.start()
        if self._registration:
            self._registration.announce()

    def _addresses(self) -> tuple[str, str]:
        """Return the address to listen at and the one to register. Raises GrabberError."""
        bind = self._address[0]
        if bind not in ("", "0.0.0.0", "::"):
            return bind, bind
        if self._names is None:
            return bind or "127.0.0.1", bind or "127.0.0.1"
        host = registered_address() or sockets.local_address_towards(*self._names.server.address)
        return bind or host, host

    def give_up_name(self) -> None:
        """Start to unregister the name, so that a later `close` hardly waits. Returns immediately."""
        if self._registration:
            self._registration.give_up()

    def close(self) -> None:
        """Close all connections, and unregister the name. May be called twice; never raises."""
        if not self._listener.is_open:
            return
        self._listener.stop()
        inputs = self._registry.close()
        self._close_outputs()
        for connection in inputs:
            connection.abort()
        deadline = time.monotonic() + END_SECONDS
        for connection in inputs:
            connection.join(deadline)
        if self._registration:
            self._registration.close()
            self._registration = None
        self._listener.close()

    def __enter__(self) -> Port:
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _prepare(self) -> None:
        """Register the name, after it listens and before anything is accepted. Raises GrabberError."""
        if self._names:
            self._registration = Registration(self.contact, self._names)
            self._registration.open()

    def _welcome(self, sock: socket.socket, address: str) -> None:
        """Serve an accepted connection. Raises ResourceExhaustedError if there is no thread left."""
        if not self._allowed.allows(address, sock.getsockname()[0]):
            self._strangers.warn(f"connection from {address} refused; allowed: {self._allowed}")
            sockets.shut_down(sock)
            return
        try:
            connection = Input(self, sock)
        except OSError:  # the peer has closed it already
            sock.close()
            return
        self._registry.add(connection)

    @property
    def port_number(self) -> int:
        """The TCP port at which it listens; 0 before it is open."""
        return self.contact.port

    def place(self) -> str:
        """`tcp://HOST:PORT/`."""
        return f"tcp://{self.contact.host}:{self.contact.port}/"

    @property
    def connections(self) -> int:
        """Number of connected readers; without any, no message needs to be prepared."""
        return len(self._registry.outputs)

    @property
    def outputs(self) -> list[Output]:
        """The connections to readers."""
        return self._registry.outputs

    @property
    def peers(self) -> list[Input]:
        """The connections of other ports that send or ask here; short-lived ones of tools are left out."""
        return [peer for peer in self._registry.inputs if peer.peer.startswith("/") and not peer.sends]

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        """Return the carrier of each connection, by the name at its other end."""
        if outgoing:
            return {output.reader: output.carrier_text for output in self._registry.outputs}
        return {source.peer: source.carrier for source in self._registry.inputs if source.peer}

    def locate(self, name: str) -> tuple[str, int]:
        """Return host and port of a name. Raises SourceNotFoundError, SourceUnavailableError."""
        if literal := literal_address(name):
            return literal[1:]
        if name == self.name:
            return self.contact.address
        if self._names is None:
            raise SourceNotFoundError(
                f"{name} cannot be looked up without a name server; write tcp://HOST:PORT/"
            )
        return self._names.query(name).address

    def add(self, target: Target) -> None:
        """Connect to a reader, replacing an existing connection to it.

        Raises SourceNotFoundError, LocalProtocolError for a carrier or plug-in that we lack, TransportError.
        """
        if wire.by_name(target.carrier).pull:
            if plug_in := target.modifiers.get("recv"):
                raise LocalProtocolError(f"{self.name} runs no plug-ins, {plug_in} must run at the other end")
            self._pull(target)
        elif self.sends:
            self._connect(target)
            if plug_in := target.modifiers.get("send"):
                # A YARP without the plug-in connects as well, and says so in its log.
                self._strangers.warn(f"there is no plug-in {plug_in}: {target.name} gets messages unchanged")
        else:
            raise TransportError(NO_OUTPUT)

    def _connect(self, target: Target) -> None:
        carrier = wire.by_name(target.carrier)
        address = self.locate(target.name)
        if self._is_own(address):
            raise TransportError(f"{self.name} cannot send to itself")
        if not self._allowed.allows(address[0], self.contact.host):
            raise TransportError(f"{address[0]} is not among the allowed addresses ({self._allowed})")
        self.remove_output(target.name)
        join = partial(self._groups.join, carrier=target.carrier)
        sender = target.sender(self.name)
        link, membership = connect(self.name, sender, target.name, address, carrier, self.key, join)
        output = Output(
            self.name,
            target.name,
            carrier,
            link,
            carrier_text=target.carrier,
            listens_at=address,
            membership=membership,
            on_close=self._registry.remove,
        )
        self._registry.add(output)

    def _is_own(self, address: tuple[str, int]) -> bool:
        """Return whether this port listens at an address; its messages would come back as requests."""
        host, port = address
        return port == self.contact.port and (host == self.contact.host or sockets.is_this_machine(host))

    def _pull(self, target: Target) -> None:
        raise TransportError(
            f"Cannot pull from {target.name}: this port takes no input over {target.carrier}"
        )

    def remove_output(self, name: str) -> bool:
        """Close the connections to `name`; return whether there were any."""
        found = [output for output in self._registry.outputs if output.reader == name]
        for output in found:
            output.close()
            self._registry.remove(output)
            self._report_end(output)
        return bool(found)

    def remove_input(self, name: str) -> bool:
        """Close the connections from `name`; return whether there were any."""
        found = self._inputs_from(name)
        for connection in found:
            connection.abort()
        return bool(found)

    def _inputs_from(self, sender: str) -> list[Input]:
        return [connection for connection in self._registry.inputs if connection.peer == sender]

    def _close_outputs(self) -> None:
        """Close all at once. Waits for readers of udp that hang, REPORT_SECONDS at most."""
        outputs = self._registry.outputs
        for output in outputs:
            output.abort()
        for output in outputs:
            output.close()
            self._registry.remove(output)
        ends = {
            f"yarp {self.name} leaves {output.reader}": partial(self._report_end, output)
            for output in outputs
        }
        run_all(ends, REPORT_SECONDS)
        self._groups.close(REPORT_SECONDS)

    def _report_end(self, output: Output) -> None:
        """Notify a reader of udp or mcast, which cannot notice the end. Never raises."""
        if not output.carrier.datagrams or output.listens_at is None:
            return
        try:
            report_end(self.name, output.listens_at, self.key)
        except GrabberError as error:
            log.debug("%s: %s does not know of the end: %s", self.name, output.reader, error)

    def register(self, connection: Input) -> None:
        """Accept a connection whose sender is known, and close any older connection from the same port."""
        if connection.peer.startswith("/"):
            for other in self._inputs_from(connection.peer):
                if other is not connection:
                    other.abort()

    def unregister(self, connection: Input) -> None:
        """Forget a connection that has ended."""
        self._registry.remove(connection)

    def warn(self, text: str) -> None:
        """Log a peer's fault, at a limited rate."""
        self._strangers.warn(text)

    def allocate(self, size: int) -> memoryview:
        """Return memory for a body."""
        return new_memory(size)

    def deliver(self, request: Request) -> Reply:
        """Answer where there is a handler; its refusal is a reply as well."""
        if self._handler is None:
            return None
        try:
            return self._handler(request)
        except GrabberError as error:
            self._refusals.warn(f"request of {request.info.peer} refused: {error}")
            return Bottle([Vocab("fail"), str(error)])

    def attach(
        self,
        reader: str,
        carrier: Carrier,
        link: Link,
        *,
        replaces: Input | None = None,
        on_made: Callable[[Output], None] | None = None,
    ) -> Output:
        """Send the output on a connection that a reader opened, and reversed if it `replaces` its input.

        `on_made` gets the output before it is listed and sends. Raises GrabberError.
        """
        if not self.sends:
            link.close()
            raise TransportError(f"{self.name} sends nothing")
        output = Output(self.name, reader, carrier, link, on_close=self._registry.remove)
        if replaces is not None:
            output.active = replaces.active
        if on_made is not None:
            on_made(output)
        self._registry.add(output, replaces=replaces)
        return output
