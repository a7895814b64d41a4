"""A port's answers to administrative requests: `yarp connect`, `yarp ping`, `yarp admin rpc`, a browser.

No I/O.
"""

from __future__ import annotations

import logging
from typing import Final, Protocol

from grabbergui.core.errors import GrabberError, LocalProtocolError, RemoteProtocolError, SourceNotFoundError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.target import Target
from grabbergui.net.yarp.os.values import Item, Vocab, word
from grabbergui.net.yarp.os.web_page import encode_page

log = logging.getLogger(__name__)

_MOST_REFUSALS: Final = 32
"""Reasons to refuse a connection that are logged as warnings."""

_HELP: Final = (
    "[help]                  # give this help",
    "[ver]                   # report protocol version information",
    "[add] $portname         # add an output connection",
    "[add] $portname $car    # add an output with a given protocol",
    "[del] $portname         # remove an input or output connection",
    "[list] [in]             # list input connections",
    "[list] [out]            # list output connections",
    "[list] [in]  $portname  # give details for input",
    "[list] [out] $portname  # give details for output",
    "[prop] [get]            # get all user-defined port properties",
    "[prop] [get] $prop      # get a user-defined port property",
    "[prop] [set] $prop $val # set a user-defined port property",
)
_VERSION: Final = (Vocab("ver"), 1, 2, 3)
_MANY_PROPERTIES: Final = 256
_PROPERTY_BYTES: Final = 4096

_LINE_HELP: Final = (
    "This is a YARP port.  Here are the commands it responds to:",
    "*       Gives a description of this port",
    "d       Signals the beginning of input for the port's owner",
    'do      The same as "d" except replies should be suppressed ("data-only")',
    "q       Disconnects",
    "r       Reverse connection type to be a reader",
    "/port   Requests to send output to /port",
    "!/port  Requests to stop sending output to /port",
    "~/port  Requests to stop receiving input from /port",
    "a       Signals the beginning of an administrative message",
    "?       Gives this help",
)
_NOT_UNDERSTOOD: Final = (
    "Port command not understood.",
    "Type d to send data to the port's owner.",
    "Type ? for help.",
)


class Administered(Protocol):
    """A port as its commands see it."""

    name: str
    properties: dict[str, Item]

    def place(self) -> str:
        """`tcp://HOST:PORT/`."""

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        """Return the carrier of each connection, by the name at its other end."""

    def add(self, target: Target) -> None:
        """Connect. Raises GrabberError."""

    def remove_output(self, name: str) -> bool:
        """Close the connections to `name`; return whether there were any."""

    def remove_input(self, name: str) -> bool:
        """Close the connections from `name`; return whether there were any."""


class PortCommands:
    """Answers what peers ask of one port. Any thread; raises nothing for what a peer may ask."""

    def __init__(self, port: Administered, *, images: bool) -> None:
        """The page for a browser shows the port's output if it sends `images`."""
        self._port = port
        self._images = images
        self._refusals: set[str] = set()
        "Reasons that were logged as warnings."

    def administer(self, request: list[Item]) -> Bottle:
        """Return the reply to an administrative Bottle."""
        words = [word(item) for item in request] + [""] * 3
        match words[0]:
            case "ver":
                return Bottle(_VERSION)
            case "help":
                return Bottle([Vocab("many"), *_HELP])
            case "add":
                return _outcome(*self._add(words[1], words[2]))
            case "del":
                return _outcome(*_remove(self._port, words[1]))
            case "list":
                return _list(self._port, words[1], words[2])
            case "prop" | "get" | "set":
                return _properties(self._port, words, request)
            case "atch" | "dtch":
                return Bottle([Vocab("fail")])
        return Bottle([Vocab("fail"), "send [help] for list of valid commands"])

    def line(self, command: str) -> list[str]:
        """Execute a command line of text mode; return the lines of its answer."""
        port, name = self._port, command[1:]
        match command[:1]:
            case "*":
                return _describe(port)
            case "?" | "h":
                return list(_LINE_HELP)
            case "!" if port.remove_output(name):
                return [_removed(port, name)]
            case "!":
                return [f"Could not find an outgoing connection to {name}"]
            case "~" if port.remove_input(name):
                return [f"Removing connection from {name} to {port.name}"]
            case "~":
                return [f"Could not find an incoming connection from {name}"]
        if "/" in command:
            return [self._add(command, "")[1]]
        return list(_NOT_UNDERSTOOD)

    def page(self) -> bytes:
        """Return the HTTP response for a browser: the connections, and the images if the port sends some."""
        return encode_page(self._port.name, self.line("*"), images=self._images)

    def answer_name_query(self, line: str, asker: str) -> str:
        """Answer a line to a name server. Raises RemoteProtocolError, as this port is none."""
        raise RemoteProtocolError(f"{self._port.name} is no name server")

    def _add(self, name: str, carrier: str) -> tuple[int, str]:
        port = self._port
        try:
            port.add(Target.parse(name, carrier))
        except GrabberError as error:
            self._log_refusal(name, error)
            if isinstance(error, SourceNotFoundError):
                return -1, f"Do not know how to connect to {name}"
            return -1, f"Cannot connect to {name}: {error}"
        shown = f"{carrier}:/{name}" if carrier else name
        return 0, f"Added connection from {port.name} to {shown}"

    def _log_refusal(self, name: str, error: GrabberError) -> None:
        """Log a refused connection; a carrier or plug-in that we lack as a warning, once.

        A peer that tries again and again does not fill the log.
        """
        level, reason = logging.INFO, str(error)
        known = reason in self._refusals or len(self._refusals) >= _MOST_REFUSALS
        if isinstance(error, LocalProtocolError) and not known:
            self._refusals.add(reason)
            level = logging.WARNING
        log.log(level, "%s: no connection to %s: %s", self._port.name, name, error)


def _outcome(code: int, text: str) -> Bottle:
    return Bottle([code, text + "\r\n"])


def _remove(port: Administered, name: str) -> tuple[int, str]:
    if port.remove_output(name):
        return 0, _removed(port, name)
    if port.remove_input(name):
        return 0, f"Removed connection from {name} to {port.name}"
    outgoing, incoming = f"an outgoing connection to {name}", f"an incoming connection from {name}"
    return -1, f"Could not find {outgoing}\r\nCould not find {incoming}"


def _removed(port: Administered, name: str) -> str:
    return f"Removed connection from {port.name} to {name}"


def _list(port: Administered, direction: str, name: str) -> Bottle:
    outgoing = direction == "out"
    carriers = port.carriers(outgoing=outgoing)
    if not name:
        return Bottle(carriers)
    if name not in carriers:
        return Bottle()
    ends = (port.name, name) if outgoing else (name, port.name)
    carrier = carriers[name]
    details: list[Item] = [["from", ends[0]], ["to", ends[1]], ["carrier", carrier]]
    if carrier.startswith(("udp", "mcast")):
        details.append(["connectionless", 1])
    if carrier.startswith("mjpeg"):
        details.append(["push", 0])
    return Bottle(details)


def _properties(port: Administered, words: list[str], request: list[Item]) -> Bottle:
    if words[0] != "prop":  # of a connection, which has none
        if words[0] == "get":
            return Bottle([Bottle()]) if words[2] else Bottle()
        return _outcome(0, f"Configured connection to {words[2]}")
    if words[1] == "get":
        if not words[2]:
            # A copy, as another peer may set one.
            return Bottle([key, value] for key, value in list(port.properties.items()))
        return Bottle([port.properties[words[2]]] if words[2] in port.properties else [])
    if words[1] != "set" or len(request) < 4 or not words[2]:
        return Bottle([Vocab("fail")])
    if words[2] not in port.properties and len(port.properties) >= _MANY_PROPERTIES:
        return Bottle([Vocab("fail"), f"a port keeps {_MANY_PROPERTIES} properties"])
    try:
        size = len(words[2]) + len(Bottle([request[3]]).encode())
    except LocalProtocolError as error:  # a vocab of 4.0, which would break every list of the properties
        return Bottle([Vocab("fail"), str(error)])
    if size > _PROPERTY_BYTES:
        return Bottle([Vocab("fail"), f"a property has at most {_PROPERTY_BYTES} bytes"])
    port.properties[words[2]] = request[3]
    return Bottle([Vocab("ok")])


def _describe(port: Administered) -> list[str]:
    lines = [f"This is {port.name} at {port.place()}"]
    outputs, inputs = port.carriers(outgoing=True), port.carriers(outgoing=False)
    lines += [
        f"There is an output connection from {port.name} to {name} using {carrier}"
        for name, carrier in outputs.items()
    ] or ["There are no outgoing connections"]
    lines += [
        f"There is an input connection from {name} to {port.name} using {carrier}"
        for name, carrier in inputs.items()
    ] or ["There are no incoming connections"]
    return lines
