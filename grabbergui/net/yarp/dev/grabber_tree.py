"""The vocabulary of `net.tree_service` on a frame grabber's RPC port, in addition to YARP's.

A request is a Bottle of strings, ``genicam VERB ARGUMENT…``; the reply is ``genicam ok JSON`` or
``genicam error KIND MESSAGE FEATURE``. Other servers answer the unknown word with ``[nak]`` (3.x) or
``[fail]`` (4.0), so a client may always ask. Users can type it too: ``genicam write Gain 5`` into ``yarp
rpc``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from grabbergui.core.errors import GrabberError, RemoteProtocolError
from grabbergui.core.grabber import DeviceInfo
from grabbergui.net.feature_json import dumps, error_of, loads, read_info, table_of
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Item, word

WORD = "genicam"


def request(verb: str, *arguments: str) -> Bottle:
    """Return the message that asks for `verb`."""
    return Bottle([WORD, verb, *arguments])


def is_request(message: Sequence[Item]) -> bool:
    """Return whether a message is in this vocabulary."""
    return bool(message) and word(message[0]) == WORD


def success(result: object) -> Bottle:
    """Return the reply that carries a result: plain data, or any of the dataclasses named above."""
    return Bottle([WORD, "ok", dumps(result)])


def failure(error: GrabberError) -> Bottle:
    """Return the reply that carries an error; the other end raises it again."""
    return Bottle([WORD, "error", type(error).__name__, str(error), getattr(error, "feature", "")])


def read_reply(reply: Sequence[Item]) -> Any:
    """Return the plain data of a reply.

    Raises the error that the other end reported, RemoteProtocolError for anything but a reply of this
    vocabulary.
    """
    texts = [item for item in reply if isinstance(item, str)]
    if len(texts) != len(reply) or texts[:1] != [WORD] or len(texts) < 3:
        raise RemoteProtocolError(f"'{WORD}' was answered with something else")
    if texts[1] == "ok":
        return loads(texts[2])
    raise error_of(texts[2], texts[3] if len(texts) > 3 else "", texts[4] if len(texts) > 4 else "")


def understood(reply: Sequence[Item]) -> bool:
    """Return whether the other end knows this vocabulary."""
    return len(reply) > 1 and reply[0] == WORD


def read_hello(reply: Sequence[Item]) -> DeviceInfo:
    """Return the camera behind a server that answered `hello`. Raises as `read_reply`."""
    return read_info(table_of(read_reply(reply)).get("info"))
