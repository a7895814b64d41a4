"""The names of ports: registered, taken by others, kept, given up."""

import itertools
import os
import socket
import threading
import time
from contextlib import closing, contextmanager
from http.client import HTTPConnection

import pytest

from grabbergui.core.errors import SourceNotFoundError, TransportError, UsageError
from grabbergui.net.yarp.os import registration, sockets
from grabbergui.net.yarp.os.contact import Contact
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.port import Port
from grabbergui.net.yarp.os.ports import OutputPort, RpcServer, open_all
from grabbergui.net.yarp.os.registration import Registration
from patience import PATIENCE, until

pytestmark = pytest.mark.usefixtures("no_thread_is_left")


def browse(address, path="/"):
    connection = HTTPConnection(*address, timeout=PATIENCE)
    with closing(connection):
        connection.request("GET", path)
        response = connection.getresponse()
        return response.status, response.read().decode()


def test_a_browser_finds_its_way_from_the_name_server_to_the_images(names):
    with OutputPort("/out", names) as output, RpcServer("/rpc<b>", lambda request: None, names) as server:
        status, page = browse(names.server.address)
        assert status == 200 and f'/out at <a href="http://127.0.0.1:{output.port_number}/">' in page
        status, page = browse(output.contact.address)
        assert status == 200 and f'This is /out at <a href="http://127.0.0.1:{output.port_number}/' in page
        assert '<img src="/?action=stream" alt="/out">' in page
        _, page = browse(server.contact.address)
        assert "/rpc&lt;b&gt;" in page and "<b>" not in page and "<img" not in page
        assert browse(output.contact.address, "/favicon.ico") == (404, "")


def test_a_port_returns_to_a_name_server_that_was_restarted(monkeypatch):
    monkeypatch.setattr(registration, "KEEP_SECONDS", 0.05)
    server = NameServer(port=0)
    server.open()
    names = NameClient(server.contact)
    with OutputPort("/out", names) as output:
        number = server.contact.port
        server.close()
        time.sleep(0.1)
        with NameServer(port=number):
            until(lambda: any(known.name == "/out" for known in names.list()), "the name")
            assert names.query("/out").address == output.contact.address


class Looking(threading.Event):
    """The pauses of a registration on a clock of their own; in each of them something may happen."""

    def __init__(self, end, on_pause):
        super().__init__()
        self.now, self._end, self._on_pause = 0.0, end, on_pause

    def wait(self, timeout=None):
        self._on_pause(self.now)
        self.now += timeout
        return self.now >= self._end


@contextmanager
def registered(names, end, on_pause):
    looking = Looking(end, on_pause)
    contact = Contact("/out", "127.0.0.1", 12345)
    ours = Registration(contact, names, lambda: looking.now)
    ours._closing = looking
    ours.open()
    until(lambda: looking.now >= end, "the end")
    try:
        yield contact.address
    finally:
        ours.close()


def test_a_name_that_is_overwritten_is_registered_again_ever_more_rarely(caplog):
    back = []
    with NameServer(port=0) as server:
        names = NameClient(server.contact)

        def overwrite(now):
            if names.query("/out").port != 666:
                back.append(now)
                names.register("/out", "tcp", "10.6.6.6", 666)

        with registered(names, 1600, overwrite):
            pass
    assert [later - earlier for earlier, later in itertools.pairwise(back)] == [
        *(5, 10, 20, 40, 80, 160, 300, 300, 300, 300)
    ]
    warnings = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert len(warnings) == len(back) - 1 and "10.6.6.6:666 took this name" in warnings[0]


def test_a_name_is_back_at_once_when_the_other_port_leaves_after_a_long_dispute():
    unknown, known_at_the_end = [], []
    with NameServer(port=0) as server:
        names = NameClient(server.contact)

        def overwrite_for_a_while(now):
            nonlocal known_at_the_end
            known_at_the_end = [known.address for known in names.list("/out")]
            if now < 1000:
                names.register("/out", "tcp", "10.6.6.6", 666)
            elif now == 1000:
                names.unregister("/out")
            elif not any(known.name == "/out" for known in names.list()):
                unknown.append(now)

        with registered(names, 1100, overwrite_for_a_while) as address:
            assert not unknown
            assert known_at_the_end == [address]


def test_a_name_server_that_hangs_does_not_hold_up_the_end_of_a_port(monkeypatch):
    monkeypatch.setattr(registration, "KEEP_SECONDS", 0.01)
    monkeypatch.setattr(registration, "GIVE_UP_SECONDS", 0.05)
    hanging = threading.Event()
    with NameServer(port=0) as server:
        names = NameClient(server.contact)
        ask = names.ask

        def slow_ask(command):
            if hanging.is_set():
                asked.set()
                over.wait(PATIENCE)
            return ask(command)

        monkeypatch.setattr(names, "ask", slow_ask)
        asked, over = threading.Event(), threading.Event()
        with OutputPort("/out", names):
            hanging.set()
            assert asked.wait(PATIENCE)
            begun = time.monotonic()
        assert time.monotonic() - begun < PATIENCE / 2
        over.set()
        until(lambda: not names.list("/out"), "the end of the name, once the server answers")


def test_a_port_that_closes_leaves_its_name_to_the_one_that_took_it():
    with NameServer(port=0) as server:
        names = NameClient(server.contact)
        with OutputPort("/out", names):
            names.register("/out", "tcp", "10.6.6.6", 666)
        assert names.query("/out").port == 666


def test_a_taken_name_is_refused_and_its_owner_named(names):
    with OutputPort("/out", names) as first:
        second = OutputPort("/out", names)
        with pytest.raises(TransportError) as caught:
            second.open()
        place = f"{first.contact.host}:{first.contact.port}"
        assert str(caught.value) == (
            f"/out is taken by the port at {place}, of process {os.getpid()}; end that program, or choose "
            "another name"
        )
        assert names.query("/out").address == first.contact.address
    with second:
        assert names.query("/out").address == second.contact.address


def test_a_name_is_taken_over_from_a_port_that_is_gone_hangs_or_has_another_name(names, monkeypatch):
    monkeypatch.setattr(registration, "HOLDER_SECONDS", 0.05)
    with socket.create_server(("127.0.0.1", 0)) as hanging, OutputPort("/other") as other:
        for number in (1, hanging.getsockname()[1], other.port_number):
            names.register("/out", "tcp", "127.0.0.1", number)
            with OutputPort("/out", names) as output:
                assert names.query("/out").address == output.contact.address


def test_no_name_server_means_no_port(names):
    gone = NameClient(Port("/x").contact)
    with pytest.raises(Exception, match=r"name server|no way|cannot"):
        OutputPort("/out", gone, bind="127.0.0.1").open()


@pytest.mark.parametrize("address", ["300.1.1.1", "192.0.2.1"])
def test_an_address_of_another_computer_is_refused_with_a_message(address):
    with pytest.raises(TransportError) as caught:
        OutputPort("/out", bind=address).open()

    assert f"/out cannot listen at {address}: " in str(caught.value)
    assert str(caught.value).endswith("; is it an address of this machine?")
    assert "Errno" not in str(caught.value)


def test_ports_that_belong_together_are_all_open_or_none(names, monkeypatch):
    first, second = OutputPort("/both/first", names), OutputPort("/both/second", names)

    def refuse():
        raise TransportError("no room")

    with monkeypatch.context() as patched, pytest.raises(TransportError, match="no room"):
        patched.setattr(second, "open", refuse)
        open_all([first, second])
    with pytest.raises(SourceNotFoundError):
        names.query("/both/first")
    open_all([first, second])
    with closing(first), closing(second):
        assert names.query("/both/first").address == first.contact.address


def test_a_second_name_server_refers_to_the_first(names):
    with pytest.raises(TransportError, match=r"runs at 127\.0\.0\.1:\d+ already: use that one"):
        NameServer(port=names.server.port).open()


def test_the_environment_renames_ports_as_yarp_does(names, monkeypatch):
    monkeypatch.setenv("YARP_RENAME_left_rpc", "/requests")
    monkeypatch.setenv("YARP_PORT_PREFIX", "/robot")
    with OutputPort("/left", names) as output, RpcServer("/left/rpc", lambda request: None, names) as server:
        assert (output.name, server.name) == ("/robot/left", "/robot/requests")
        assert names.query("/robot/requests").address == server.contact.address
    with NameServer(port=0) as name_server:
        assert name_server.name == "/root"


def test_the_environment_chooses_the_number_of_a_port(monkeypatch):
    with OutputPort("/left") as output:
        number = output.port_number
    monkeypatch.setenv("YARP_PORTNUMBER_left", str(number))
    monkeypatch.setenv("YARP_RENAME_left", "/right")
    with OutputPort("/left") as output:
        assert (output.name, output.port_number) == ("/right", number)


@pytest.mark.parametrize(
    ("variable", "value", "reason"),
    [
        ("YARP_RENAME_left", "right", "YARP_RENAME_left=right: 'right' cannot name a port"),
        ("YARP_PORT_PREFIX", "robot", "YARP_PORT_PREFIX=robot: 'robot/left' cannot name a port"),
        ("YARP_PORTNUMBER_left", "65536", "YARP_PORTNUMBER_left=65536 is no TCP port"),
        ("YARP_PORTNUMBER_left", "ten", "YARP_PORTNUMBER_left=ten is no TCP port"),
        ("YARP_IP", "999", "YARP_IP=999 begins no address of this machine: .*127"),
    ],
)
def test_a_variable_that_cannot_be_obeyed_is_named(names, monkeypatch, variable, value, reason):
    monkeypatch.setenv(variable, value)
    with pytest.raises(UsageError, match=reason):
        OutputPort("/left", names).open()


@pytest.mark.parametrize(
    ("wanted", "bind", "registered", "listens"),
    [
        ("127", "", "127.0.0.1", "127.0.0.1"),
        ("127.22.0.3", "", "127.22.0.3", "127.22.0.3"),
        ("192.0.2.7", "0.0.0.0", "192.0.2.7", "0.0.0.0"),
        ("192.0.2.7", "127.22.0.4", "127.22.0.4", "127.22.0.4"),
    ],
    ids=["beginning", "whole", "forwarded", "option"],
)
def test_the_environment_chooses_the_address_that_is_registered(
    names, monkeypatch, wanted, bind, registered, listens
):
    monkeypatch.setattr(sockets, "local_addresses", lambda: ["10.0.0.1", "127.0.0.1"])
    monkeypatch.setenv("YARP_IP", wanted)
    listening = []
    listen = sockets.listen
    monkeypatch.setattr(sockets, "listen", lambda address: listening.append(address[0]) or listen(address))
    with OutputPort("/left", names, bind=bind):
        assert names.query("/left").host == registered and listening == [listens]
