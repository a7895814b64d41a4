"""The readers of a port: connects to them, and sends them messages."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence

from grabbergui.config.allowed_addresses import AllowedAddresses
from grabbergui.core.errors import GrabberError, TransportError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import Carrier
from grabbergui.net.yarp.os.inputs import Input
from grabbergui.net.yarp.os.link import Link, report_end
from grabbergui.net.yarp.os.names import Target
from grabbergui.net.yarp.os.outputs import Outgoing, Output, connect
from grabbergui.net.yarp.os.registry import Registry

log = logging.getLogger(__name__)


class Readers:
    """The outgoing connections of one port. Any thread.

    `locate` returns the host and TCP port of a name. `key` is that of `auth.conf`.
    """

    def __init__(
        self,
        source: str,
        registry: Registry,
        locate: Callable[[str], tuple[str, int]],
        allowed: AllowedAddresses,
        key: bytes | None,
    ) -> None:
        self._source = source
        self._registry = registry
        self._locate = locate
        self._allowed = allowed
        self._key = key

    def __len__(self) -> int:
        return len(self._registry.outputs)

    @property
    def dropped(self) -> int:
        """Messages for which connected readers were too slow, in total."""
        return sum(output.dropped for output in self._registry.outputs)

    def connect(self, target: Target, own_host: str) -> None:
        """Connect to a reader, replacing an existing connection to it.

        Raises SourceNotFoundError, LocalProtocolError for a carrier that we lack, TransportError.
        """
        carrier = wire.by_name(target.carrier)
        address = self._locate(target.name)
        if not self._allowed.allows(address[0], own_host):
            raise TransportError(f"{address[0]} is not among the allowed addresses ({self._allowed})")
        self.disconnect(target.name)
        sender = target.sender(self._source)
        link = connect(self._source, sender, target.name, address, carrier, self._key)
        self._start(self._output(target.name, carrier, link, target.carrier))

    def attach(self, reader: str, carrier: Carrier, link: Link, *, replaces: Input | None = None) -> Output:
        """Send on a connection that a reader opened, and reversed if it `replaces` its input.

        Raises GrabberError.
        """
        output = self._output(reader, carrier, link)
        self._start(output, replaces)
        return output

    def disconnect(self, name: str) -> bool:
        """Close the connections to `name`; return whether there were any."""
        found = self._registry.outputs_to(name)
        for output in found:
            self._close(output)
        return bool(found)

    def close(self) -> None:
        """Close all connections."""
        for output in self._registry.outputs:
            self._close(output)

    def send(self, parts: Sequence[Buffer], envelope: str = "") -> None:
        """Pass a message to every reader. Never waits, and holds `parts` until all readers have it."""
        outputs = self._registry.outputs
        if outputs:
            message = Outgoing(parts, envelope)
            for output in outputs:
                output.put(message)

    def wait_sent(self, timeout: float) -> bool:
        """Wait until no message waits for a reader; return whether that was so within `timeout` seconds."""
        deadline = time.monotonic() + timeout
        return all(output.wait_taken(deadline - time.monotonic()) for output in self._registry.outputs)

    def _output(self, reader: str, carrier: Carrier, link: Link, carrier_text: str = "") -> Output:
        return Output(
            self._source, reader, carrier, link, carrier_text=carrier_text, on_close=self._registry.remove
        )

    def _start(self, output: Output, replaces: Input | None = None) -> None:
        try:
            self._registry.add(output, replaces=replaces)
            output.start()
        except GrabberError:
            output.abort()
            self._registry.remove(output)
            raise

    def _close(self, output: Output) -> None:
        output.close()
        self._registry.remove(output)
        if output.carrier.datagrams and output.reader.startswith("/"):
            try:
                report_end(self._source, self._locate(output.reader), self._key)
            except GrabberError as error:
                log.debug("%s: %s does not know of the end: %s", self._source, output.reader, error)
