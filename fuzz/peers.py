"""Requests and answers of peers on a network: the tree's JSON, administration, names, lines of a terminal."""

from __future__ import annotations

import functools
import itertools
import json
from typing import Any

from fuzz._input import DATA, Input, erring, joined, refusing
from grabbergui import sources
from grabbergui.core.features import FeatureKind
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.shared import ReadOnlyGrabber
from grabbergui.net import tree
from grabbergui.net.yarp import grabber_values
from grabbergui.net.yarp.grabber_service import GrabberService
from grabbergui.net.yarp.os import admin, carrier
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.connection import YarpConnection
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.name_server import NameDatabase
from grabbergui.net.yarp.os.target import Target
from grabbergui.terminal import Interpreter

MOST_EVENTS = 1000
_FEATURE = {"name": "Gain", "kind": "float", "access": "RW", "value": 1.5, "minimum": 0, "maximum": 24}
_JSON = (
    {"name": "Root", "members": [{"name": "A", "members": [_FEATURE]}, _FEATURE]},
    _FEATURE,
    {"feature": _FEATURE, "written": [["Gain", 1, 2]], "consequences": [], "also_changed": [_FEATURE]},
    {"uri": "sim:", "vendor": "v", "model": "m", "serial": "s"},
)
_LINES = ("get Gain", "set Gain 3", "list Ga", "run TimestampLatch", "auto Gain Once", "help", "watch Gain 0")
_ADMIN = ("[add] /x", "[del] /x", "[list] [in]", "[prop] [set] a 1", "[prop] [get]", "[ver]", "[help]")
_NAMES = ("register /a tcp h 10002", "list /", "query /a", "set /a ips 1", "get /a ips", "unregister /a")


def seeds() -> list[bytes]:
    """Return valid requests and answers of each kind, and captured conversations."""
    captures = [path.read_bytes()[:4096] for path in sorted((DATA / "yarp").rglob("*")) if path.is_file()]
    header = carrier.encode_header(carrier.TCP, "/me")
    return [
        *(b"\0" + json.dumps(each).encode() for each in _JSON),
        *(
            b"\1" + Bottle.from_text(f"genicam {verb}").encode()
            for verb in ("hello", "feature Gain", "set Gain 1")
        ),
        *(b"\2" + Bottle.from_text(line).encode() for line in _ADMIN),
        *(b"\3" + line.encode() for line in ("*", "?", "/x", "!/x", "~/x", "d")),
        *(b"\4" + line.encode() for line in _NAMES),
        *(b"\5" + bytes([side]) + joined([header, *captures[:2]]) for side in range(4)),
        *(b"\6" + line.encode() for line in _LINES),
    ]


def one_input(data: bytes) -> None:
    """Feed the part that the first byte chooses."""
    source = Input(data)
    parts = (_json, _requests, _administration, _lines, _names, _connections, _terminal)
    parts[source.number(1) % len(parts)](source)


@functools.cache
def _camera() -> FrameGrabber:
    camera = sources.create("sim:?width=64&height=48")
    camera.open()
    shown = ReadOnlyGrabber(camera)
    shown.open()
    return shown


def _json(source: Input) -> None:
    plain = refusing(tree.loads, source.rest().decode("utf-8", "replace"))
    refusing(tree.read_category, plain)
    feature = refusing(tree.read_feature, plain)
    if feature is not None:
        erring(tree.dumps, feature)
        if feature.kind is FeatureKind.FLOAT:
            erring(feature.validated, "1")
    refusing(tree.read_write_result, plain)
    refusing(tree.read_info, plain)


def _requests(source: Input) -> None:
    data = source.rest()
    bottle = refusing(Bottle.decode, data)
    if bottle is None:
        return
    answer = _service().answer(bottle)
    erring(grabber_values.read_tree_reply, bottle)  # it raises the error that a peer reported
    if not answer:
        raise AssertionError("no answer")


@functools.cache
def _service() -> GrabberService:
    return GrabberService(_camera())


class _Port:
    """A port that connects to nothing."""

    def __init__(self) -> None:
        self.name = "/port"
        self.properties: dict[str, Any] = {}

    def place(self) -> str:
        return "tcp://127.0.0.1:1/"

    def carriers(self, *, outgoing: bool) -> dict[str, str]:
        return {"/x": "udp"} if outgoing else {"/y": "mjpeg"}

    def add(self, target: Target) -> None:
        target.sender(self.name)

    def remove_output(self, name: str) -> bool:
        return name == "/x"

    def remove_input(self, name: str) -> bool:
        return name == "/y"


def _administration(source: Input) -> None:
    commands = admin.PortCommands(_Port(), images=True)
    bottle = refusing(Bottle.decode, source.rest())
    if bottle is not None:
        commands.administer(bottle).encode()


def _lines(source: Input) -> None:
    commands = admin.PortCommands(_Port(), images=True)
    commands.line(source.rest().decode("utf-8", "replace"))
    if b"<script" in commands.page():
        raise AssertionError("markup of a peer")


def _names(source: Input) -> None:
    names = NameDatabase(Contact("/root", "127.0.0.1", 10_000))
    for line in source.rest().decode("utf-8", "replace").splitlines()[:50]:
        erring(names.answer, line, "127.0.0.1")
        bottle = refusing(Bottle.from_text, line)
        if bottle is not None:
            erring(names.bot, [str(item) for item in bottle], "127.0.0.1")


def _connections(source: Input) -> None:
    side = source.number(1)
    connection = YarpConnection(opener=bool(side & 1))
    for data in source.messages():
        connection.receive_data(data)
        for _ in range(MOST_EVENTS):
            event = erring(connection.next_event)
            if event is None or not hasattr(event, "__dataclass_fields__"):
                break


def _terminal(source: Input) -> None:
    interpreter = Interpreter(_camera(), remote=True)
    for line in itertools.islice(source.rest().decode("utf-8", "replace").splitlines(), 20):
        if not line.lstrip().startswith(("watch", "auto", "'watch", '"watch')):  # they take seconds
            erring(interpreter.execute, line)
    erring(SettingKey.parse, "x")
