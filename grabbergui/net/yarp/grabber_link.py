"""The client's end of a frame grabber's RPC: makes requests and reads their answers."""

from __future__ import annotations

from typing import Any, Protocol

from grabbergui.core.errors import (
    AckTimeoutError,
    RemoteProtocolError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
)
from grabbergui.core.identity import DeviceInfo
from grabbergui.net.remote_grabber import RemoteFeatures, reached_by
from grabbergui.net.tree import TIMEOUT as TREE_TIMEOUT
from grabbergui.net.tree import TreeFeatures
from grabbergui.net.yarp import grabber_values
from grabbergui.net.yarp.client_numbers import NumberFeatures
from grabbergui.net.yarp.grabber_rpc import (
    Call,
    CallReply,
    Operation,
    ReturnValue,
    encode_request,
    read_reply,
)
from grabbergui.net.yarp.grabber_values import Value
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.values import Dialect

TIMEOUT = 2.0
"""Seconds for one request to a server of YARP's own."""


class Features(RemoteFeatures, Protocol):
    """Features whose changes must be polled."""

    def changes(self) -> frozenset[str]:
        """Return the names of features that others changed since the last call."""


class GrabberLink:
    """The request side of a remote frame grabber. One thread at a time."""

    def __init__(self, name: str, names: NameClient, *, timeout: float | None = None) -> None:
        """Connect and find out what the server speaks; `timeout` is TIMEOUT unless given.

        Raises SourceNotFoundError, SourceUnavailableError from the name server, TransportError where the
        port does not answer.
        """
        self._name, self._names = name, names
        self._timeout = TIMEOUT if timeout is None else timeout
        self._camera = DeviceInfo("")
        self.silent = False
        "True if the port answers no requests and only sends images."
        self.failed = ""
        "Why a request for a feature got no answer from a server of ours; empty if each got one."
        self._deaf = False
        "True if the port does not even acknowledge requests; then none is sent."
        self._rpc = RpcClient(_request_port(name, names), names, sender=f"grabbergui{name}")
        try:
            self.dialect, self.ours = self._find_dialect()
        except AckTimeoutError:
            self._rpc.close()
            if self._rpc.target != name:
                raise
            # A program's image port takes a request for the start of an image, and waits for the rest.
            self.silent = self._deaf = True
            self.dialect, self.ours = Dialect.YARP3, False
        except BaseException:
            self._rpc.close()
            raise

    def features(self) -> Features:
        """Return the features that the server offers. Takes many requests."""
        return TreeFeatures(self._ask_tree) if self.ours else NumberFeatures(self.ask)

    def info(self, info: DeviceInfo) -> DeviceInfo:
        """Return `info` completed with the camera's properties that the server reports."""
        if self.ours:
            return reached_by(info, self._camera)
        description = self.ask(Operation.DESCRIPTION)
        model = str(description.values[1]) if description.ok else ""
        return reached_by(info, DeviceInfo(info.uri, model=model))

    def ask(self, operation: Operation, *arguments: Value) -> CallReply:
        """Perform an operation on the server; an invalid answer is a failure."""
        if self._deaf:
            return CallReply(status=ReturnValue.NOT_IMPLEMENTED)
        call = Call(operation, arguments, self.dialect)
        reply = self._rpc.call(encode_request(call), self._timeout)
        if reply is None:
            return CallReply(status=ReturnValue.NOT_IMPLEMENTED)
        try:
            return read_reply(call, reply)
        except RemoteProtocolError as error:
            return CallReply(status=ReturnValue.FAILED, text=str(error))

    def is_grabber(self) -> bool:
        """Return whether the server answers as a frame grabber does."""
        return self.ours or self.ask(Operation.WIDTH).ok

    def _ask_tree(self, verb: str, *arguments: str) -> Any:
        try:
            reply = self._rpc.call(grabber_values.tree_request(verb, *arguments), TREE_TIMEOUT)
        except (TransportError, SourceNotFoundError, SourceUnavailableError) as error:
            self.failed = str(error)
            raise
        return grabber_values.read_tree_reply(reply or Bottle())

    def check(self) -> None:
        """Raise TransportError or SourceNotFoundError if the server does not answer."""
        if self._deaf:
            self._names.query(self._name)
        else:
            self.ask(Operation.WIDTH)

    def close(self) -> None:
        """Close the connection. May be called twice; never raises."""
        self._rpc.close()

    def _find_dialect(self) -> tuple[Dialect, bool]:
        """Return the server's YARP version, and whether it knows our vocabulary.

        Servers of both versions reply to unknown requests, and none of these requests makes one hang.
        """
        reply = self._rpc.call(grabber_values.tree_request("hello"), self._timeout)
        self.silent = reply is None
        if reply and grabber_values.tree_understood(reply):
            self._camera = grabber_values.read_tree_hello(reply)
            return Dialect.YARP3, True
        width = self._rpc.call(encode_request(Call(Operation.WIDTH, dialect=Dialect.YARP4)), self._timeout)
        if width and isinstance(width[0], list):
            self._rpc.dialect = Dialect.YARP4
            return Dialect.YARP4, False
        return Dialect.YARP3, False


def _request_port(name: str, names: NameClient) -> str:
    """Return NAME/rpc, or the image port itself, which answers the same requests."""
    try:
        names.query(f"{name}/rpc")
        return f"{name}/rpc"
    except SourceNotFoundError:
        names.query(name)
        return name
