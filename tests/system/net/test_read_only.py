"""Served read-only, a camera can be changed by no parameter, service, command, topic or port.

Each test goes through everything that a peer may ask for, and fails if something new is not decided here. The
same requests change a camera that is served without the option, so they would be noticed.
"""

from contextlib import closing, contextmanager

import pytest

from grabbergui import sources
from grabbergui.core.features import FeatureKind
from grabbergui.core.settings import SettingKey
from grabbergui.core.shared import ReadOnlyGrabber
from grabbergui.net.tree import TreeService
from grabbergui.net.yarp.grabber_rpc import Call, Operation, encode_request, read_reply
from grabbergui.net.yarp.grabber_values import ValueKind, tree_request
from grabbergui.net.yarp.os import admin
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.link import administer
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.values import Dialect, Vocab
from grabbergui.net.yarp.server import YarpGrabberServer
from grabbergui.terminal import Interpreter, remote_terminal
from patience import PATIENCE

VERBS = {
    "hello": (),
    "tree": (),
    "feature": ("Gain",),
    "write": ("Gain", "3"),
    "set": ("BalanceRatio[BalanceRatioSelector=Blue]", "2"),
    "execute": ("AcquisitionStop",),
    "changes": ("0",),
    "terminal": ("set ReverseX true",),
}
"Each verb of the tree with arguments that change something, if it can."
LINES = {
    "list_features": "list_features",
    "get_feature": "get_feature Gain",
    "set_feature": "set_feature BlackLevel 8",
    "run": "run AcquisitionStop",
    "auto": "auto Gain Once",
    "mode": "mode Gain",
    "start": "start",
    "stop": "stop",
    "watch": "watch Gain 0.01",
    "stats": "stats",
    "help": "help",
    "exit": "exit",
}
"The same for each command of a remote terminal."
ARGUMENTS = {
    Operation.SET_VALUE: (8, 5.0),
    Operation.SET_VALUES: (3, 1.6, 1.7),
    Operation.SET_ACTIVE: (8, True),
    Operation.SET_MODE: (8, 1),
    Operation.SET_ONE_PUSH: (8,),
    Operation.SET_RESOLUTION: (96, 80),
    Operation.SET_FIELD_OF_VIEW: (60.0, 40.0),
    Operation.SET_MIRROR: (True,),
}
"Arguments of each request of YARP's frame grabbers that sets something."
BLUE = SettingKey.parse("BalanceRatio[BalanceRatioSelector=Blue]")


@contextmanager
def shown_camera(*, read_only):
    """A camera whose stream is on, and what a network gets of it."""
    with closing(sources.create("sim:?width=128&height=96&fps=50&pixel_format=BayerRG8")) as camera:
        camera.open()
        camera.start()
        if not read_only:
            yield camera, camera
            return
        shown = ReadOnlyGrabber(camera)
        shown.open()
        with closing(shown):
            yield camera, shown


def settings(camera):
    """Everything that a peer might have changed."""
    values = {
        feature.name: feature.value
        for feature in camera.features()
        if feature.kind is not FeatureKind.COMMAND and camera.offered(feature).access.writable
    }
    return values, camera.read_setting(BLUE).value, camera.streaming


def ask_everything_on_yarp(ports):
    """Send each request that a peer may send to each of the ports; return the operations that were obeyed."""
    bottles = [tree_request(verb, *arguments) for verb, arguments in VERBS.items()]
    bottles += [Bottle.from_text(line) for line in LINES.values()]
    commands = {text.split("]")[0].lstrip("[") for text in admin._HELP}
    assert commands == {"help", "ver", "add", "del", "list", "prop"}, "a new administrative command"
    obeyed = set()
    for port in ports:
        place = f"tcp://{port.contact.host}:{port.contact.port}/"
        with RpcClient(place) as client:
            for operation in Operation:
                arguments = ARGUMENTS[operation] if operation in ARGUMENTS else _any(operation)
                for dialect in [Dialect.YARP3, *[Dialect.YARP4] * bool(operation.value[0])]:
                    client.dialect = dialect
                    call = Call(operation, arguments, dialect)
                    reply = client.call(encode_request(call), PATIENCE)
                    if operation in ARGUMENTS and port.name != "/cam/terminal" and read_reply(call, reply).ok:
                        obeyed.add(operation)
                client.dialect = Dialect.YARP3
            for bottle in bottles:
                client.call(bottle, PATIENCE)
        for words in (
            *(["add", place], ["add", f"tcp://{port.contact.host}:{ports[-1].contact.port}/"]),
            *(["del", place], ["del", "/cam"], ["prop", "set", "Gain", 3], ["prop", "set", "sched", 3]),
            *(
                ["set", "in", "/cam"],
                ["atch", "out", "x"],
                ["dtch", "out"],
                ["help"],
                ["ver"],
                ["list", "in"],
            ),
        ):
            administer(port.contact.address, Bottle([Vocab(words[0]), *words[1:]]), None)
    return obeyed


def _any(operation):
    """Arguments of a request that only reads."""
    assert "set" not in operation.value[1].split()[1:2], f"decide what {operation} may set, above"
    values = {
        ValueKind.INT: 8,
        ValueKind.FLOAT: 1.0,
        ValueKind.FLAG: True,
        ValueKind.VERTICES: ((0, 0), (8, 8)),
        ValueKind.TEXT: "x",
    }
    return tuple(values[kind] for kind in operation.value[2])


def test_every_verb_and_command_is_tried():
    with shown_camera(read_only=True) as (_, shown), closing(TreeService(shown)) as tree:
        assert VERBS.keys() == tree._verbs.keys()
        assert LINES.keys() == Interpreter(shown, remote=True).commands.keys()


@pytest.mark.parametrize("read_only", [True, False])
def test_no_request_on_yarp_changes_a_camera(read_only):
    with shown_camera(read_only=read_only) as (camera, shown):
        before = settings(camera)
        with YarpGrabberServer(shown, "/cam", also_raw=True, terminal=remote_terminal(shown)) as server:
            ports = server._ports() if read_only else [server._rpc, server._terminal]
            obeyed = ask_everything_on_yarp(ports)
            changed = settings(camera) != before
            if read_only:
                assert settings(camera) == before and not obeyed
                assert camera.open_queue(1).get(PATIENCE).width == before[0]["Width"], "it still streams"
            else:
                assert changed and len(obeyed) > 3, "the same requests change a camera that may be changed"
