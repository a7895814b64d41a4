import pytest

from grabbergui.core.errors import (
    RemoteProtocolError,
    SourceNotFoundError,
    SourceUnavailableError,
)
from grabbergui.net.yarp.os import name_client
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import (
    NameServer,
)
from grabbergui.net.yarp.os.rpc_client import RpcClient


def test_a_name_is_registered_found_listed_and_given_up():
    with NameServer(port=0) as server:
        names = NameClient(server.contact)
        contact = names.register("/x", ip="127.0.0.5", port=1234)
        assert contact == Contact("/x", "127.0.0.5", 1234) == names.query("/x")
        assert [known.name for known in names.list()] == ["/root", "/x", "fallback"]
        assert names.register("...").name.startswith("/tmp/port/")
        names.unregister("/x")
        with pytest.raises(SourceNotFoundError, match="/x"):
            names.query("/x")
        assert names.query("tcp://10.0.0.9:77/").address == ("10.0.0.9", 77)
    with pytest.raises(SourceUnavailableError, match="yarp-server"):
        names.query("/x")


def test_bot_is_answered_with_a_bottle_and_everything_else_with_text():
    """As by yarpserver, where a binary request for a list gets text that `yarp rpc` cannot read."""
    with NameServer(port=0) as server, RpcClient(server.place()) as client:
        names = NameClient(server.contact)
        names.register("/x_y", ip="127.0.0.5", port=1234)
        found = [["name", "/x_y"], ["ip", "127.0.0.5"], ["port_number", 1234], ["carrier", "tcp"]]
        assert client.call(Bottle(["bot", "query", "/x_y"])) == ["port", *found]
        listed = client.call(Bottle(["bot", "list"]))
        assert listed[0] == "ports" and ["port", *found] in listed
        assert listed.to_text() + "\r\n" == server.ask("bot list", "127.0.0.1")
        assert client.call(Bottle(["bot", "query", "/z"])) == ["port", ["error", -2, "port not known"]]
        with pytest.raises(RemoteProtocolError):
            client.call(Bottle(["list"]))


def test_without_a_configuration_one_on_this_machine_is_used(monkeypatch):
    monkeypatch.setattr(name_client, "name_server", lambda: None)
    with NameServer(port=0) as server:
        monkeypatch.setattr(name_client, "DEFAULT_PORT", server.port_number)
        names = NameClient.find()
        assert names.register("/here", ip="127.0.0.5", port=1234) == names.query("/here")
    with pytest.raises(SourceUnavailableError, match="--with-name-server, or say where it is"):
        names.query("/here")
