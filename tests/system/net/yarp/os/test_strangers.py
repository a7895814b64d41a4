"""Ports among peers that mean harm, or are many: those who were there first keep working."""

import errno
import itertools
import os
import socket
import threading
import time
from contextlib import ExitStack, contextmanager

import pytest

from grabbergui.config.allowed_addresses import AllowedAddresses
from grabbergui.core.errors import ResourceExhaustedError, TransportError, UsageError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import connection_limits, inputs, sockets
from grabbergui.net.yarp.os.binary import encode_message
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.carrier import encode_header
from grabbergui.net.yarp.os.link import administer
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.port import Port
from grabbergui.net.yarp.os.ports import InputPort, OutputPort, RpcServer
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.stranger_log import StrangerLog
from grabbergui.net.yarp.os.target import Target
from grabbergui.net.yarp.os.values import Vocab
from patience import PATIENCE, until

STRANGER = "127.15.0.66"

pytestmark = pytest.mark.usefixtures("no_thread_is_left")


@pytest.fixture
def few(monkeypatch):
    """Limits that are reached with few sockets."""
    monkeypatch.setattr(connection_limits, "PORT_LIMIT", 12)
    monkeypatch.setattr(connection_limits, "ADDRESS_LIMIT", 5)


def echo(request):
    return Bottle([Vocab("ok"), *request.bottle()])


def connect(port, address=STRANGER, greeting=b""):
    """A connection to a port from another address of the loopback."""
    sock = socket.create_connection(port.contact.address, PATIENCE, source_address=(address, 0))
    sock.sendall(greeting)
    return sock


def gone(sock):
    """Whether the port has closed the connection, whatever it sent before."""
    try:
        while sock.recv(4096):
            pass
    except ConnectionError:
        pass
    return True


def test_connections_of_one_address_have_a_limit_and_the_idlest_goes(few):
    with RpcServer("/rpc", echo) as server, RpcClient(server.place()) as friend, ExitStack() as stack:
        assert friend.call(Bottle([1]))
        friends = server._registry.inputs[:]
        crowd = [stack.enter_context(connect(server, greeting=b"CONNECT /idle%d\r\n" % n)) for n in range(20)]
        assert all(gone(sock) for sock in crowd[:15])
        assert crowd[-1].recv(100) == b"Welcome /idle19\r\n"
        assert friend.call(Bottle([2])) == [Vocab("ok"), 2]
        assert set(friends) <= set(server._registry.inputs), "the same connection as before"
        assert len(server._registry.inputs) <= 6


def test_a_full_port_takes_a_newcomer_in_place_of_one_of_the_largest_crowd(few):
    with RpcServer("/rpc", echo) as server, ExitStack() as stack:
        addresses = ["127.15.0.1"] * 5 + ["127.15.0.2"] * 4 + ["127.15.0.3"] * 3
        crowd = [stack.enter_context(connect(server, address)) for address in addresses]
        until(lambda: len(server._registry.inputs) == 12, "the crowd")
        with RpcClient(server.place()) as newcomer:
            assert newcomer.call(Bottle([1])) == [Vocab("ok"), 1]
            assert gone(crowd[0])
            kept = [connection.address for connection in server._registry.inputs]
            assert sorted(kept) == sorted([*addresses[1:], "127.0.0.1"])


def test_connections_turned_round_count_too(few, monkeypatch):
    # Threads that are slow between the message and its effect let connections overtake each other.
    reverse = inputs.Input._reverse
    delays = itertools.cycle([0.02, 0.0, 0.005])
    monkeypatch.setattr(
        inputs.Input, "_reverse", lambda self, link: (time.sleep(next(delays)), reverse(self, link))
    )
    before = threading.active_count()
    with OutputPort("/out") as output, ExitStack() as stack:
        greeting = encode_header(wire.FAST_TCP, "reader") + b"".join(encode_message("r"))
        readers = [stack.enter_context(connect(output, greeting=greeting)) for _ in range(20)]
        assert all(gone(sock) for sock in readers[:15])
        until(lambda: output.connections == 5 and not output._registry.inputs, "the five that stay")
        until(lambda: threading.active_count() <= before + 6, "the end of the others' threads")
        output.write_bottle(Bottle([1]))
        assert readers[-1].recv(100)


def test_a_reader_of_mjpeg_counts_by_what_it_is_sent(few):
    with OutputPort("/out") as output, ExitStack() as stack:
        reader = stack.enter_context(connect(output, greeting=b"GET /?action=stream\n\n\r\n"))
        until(lambda: output.connections, "the reader")
        (sender,) = output._registry.outputs
        sender.messages, sender.active = 3, float("inf")  # as if images went there all the time
        for _ in range(20):
            stack.enter_context(connect(output))
        until(lambda: len(output._registry.inputs) + len(output._registry.outputs) == 5, "the limit")
        assert output.connections == 1
        reader.close()


def test_a_reader_of_mjpeg_counts_so_as_soon_as_it_is_listed(few, monkeypatch):
    attach, crowd_is_there = Port.attach, threading.Event()

    def slow_attach(self, *args, **options):
        attached = attach(self, *args, **options)
        crowd_is_there.wait(PATIENCE)
        return attached

    monkeypatch.setattr(Port, "attach", slow_attach)
    with OutputPort("/out") as output, ExitStack() as stack:
        reader = stack.enter_context(connect(output, greeting=b"GET /?action=stream\n\n\r\n"))
        until(lambda: output.connections, "the reader")
        ((accepted,), (sender,)) = output._registry.inputs, output._registry.outputs
        stack.callback(crowd_is_there.set)
        sender.messages, sender.active = 3, float("inf")
        crowd = [stack.enter_context(connect(output)) for _ in range(20)]
        assert all(gone(sock) for sock in crowd[:17])
        assert accepted in output._registry.inputs
        crowd_is_there.set()
        assert output.connections == 1
        reader.close()


def test_a_port_connects_to_no_more_readers_than_it_may(few):
    with OutputPort("/out") as output, ExitStack() as stack:
        readers = [stack.enter_context(InputPort(f"/in{n}")) for n in range(8)]
        for reader in readers:
            request = Bottle([Vocab("add"), f"fast_tcp:/{reader.place()[5:]}"])
            answer = administer(output.contact.address, request)
            assert answer[0] == 0, answer
        assert output.connections <= 5


def test_only_allowed_addresses_are_answered_and_sent_to():
    allowed = AllowedAddresses.parse(["127.15.0.0/30", "10.1.2.3"])
    with OutputPort("/out", handler=echo, bind="127.0.0.1", allowed=allowed) as output:
        with RpcClient(output.place()) as here:
            assert here.call(Bottle([1]))
        refusal = r"192.0.2.9 is not among the allowed addresses \(127.15.0.0/30, 10.1.2.3/32\)"
        with pytest.raises(TransportError, match=refusal):
            output.add(Target.parse("tcp://192.0.2.9:10003/"))


def test_a_stranger_is_hung_up_on(monkeypatch):
    monkeypatch.setattr(AllowedAddresses, "allows", lambda self, address, own="": address != STRANGER)
    with RpcServer("/rpc", echo) as server, connect(server) as stranger, RpcClient(server.place()) as friend:
        assert gone(stranger)
        assert friend.call(Bottle([1])) == [Vocab("ok"), 1]


@contextmanager
def no_descriptors():
    """Use up all of this process's descriptors."""
    resource = pytest.importorskip("resource")
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    held = [os.open(os.devnull, os.O_RDONLY)]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(held[0] + 50, hard), hard))
    try:
        while True:
            held.append(os.dup(held[0]))
    except OSError as error:
        assert error.errno == errno.EMFILE
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        for descriptor in held:
            os.close(descriptor)


def test_used_up_descriptors_are_waited_for_and_named(caplog, monkeypatch):
    accepted = []
    accept = socket.socket.accept
    monkeypatch.setattr(socket.socket, "accept", lambda self: accepted.append(self) or accept(self))
    with RpcServer("/rpc", echo) as server, socket.socket() as sock:
        with no_descriptors():
            sock.connect(server.contact.address)
            until(lambda: len(accepted) >= 2, "a second try")
        sock.sendall(b"CONNECT friend\r\n")
        sock.settimeout(PATIENCE)
        assert sock.recv(100) == b"Welcome friend\r\n"
    (warning,) = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert warning.startswith("/rpc: nobody can connect: this program has as many files and connections open")


def test_a_crowd_gives_up_a_descriptor(few, monkeypatch):
    monkeypatch.setattr(connection_limits, "CROWD", 2)
    with RpcServer("/rpc", echo) as server, ExitStack() as stack, socket.socket() as sock:
        crowd = [stack.enter_context(connect(server)) for _ in range(4)]
        until(lambda: len(server._registry.inputs) == 4, "the crowd")
        with no_descriptors():
            sock.connect(server.contact.address)
            assert gone(crowd[0])
            sock.settimeout(PATIENCE)
            sock.sendall(b"CONNECT friend\r\n")
            assert sock.recv(100) == b"Welcome friend\r\n"


def test_the_name_server_is_not_blamed_for_our_descriptors():
    with NameServer(port=0) as server:
        names = NameClient(server.contact)
        with no_descriptors(), pytest.raises(ResourceExhaustedError, match="ulimit -n"):
            names.query("/anything")
        assert names.query("/root").address == server.contact.address


def test_warnings_about_strangers_are_few(caplog):
    now = [100.0]
    strangers = StrangerLog("/port", clock=lambda: now[0])
    for _ in range(50):
        strangers.warn("refused")
    for _ in range(2):
        now[0] += 60
        strangers.warn("refused")
    assert caplog.messages == [
        "/port: refused",
        "/port: refused (49 more since the last such line)",
        "/port: refused",
    ]


def test_peers_that_send_garbage_do_not_fill_the_log(caplog):
    caplog.set_level("INFO")
    with OutputPort("/out") as output:
        for _ in range(20):
            with connect(output, greeting=b"\xff" * 12) as sock:
                assert gone(sock)
        until(lambda: not output._registry.inputs, "the end of their threads")

    (warning,) = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert STRANGER in warning
    assert "was expected" in warning


@pytest.mark.parametrize("host", ["", "localhost", "127.0.0.9"])
def test_a_port_never_sends_to_itself(host, caplog):
    """Its images would come back as requests, with a line in the log for each."""
    try:
        socket.gethostbyname(host)
    except OSError:
        pytest.skip(f"this computer does not know {host}, as a Debian without /etc/hosts")
    with OutputPort("/out") as output:
        place = f"tcp://{host or output.contact.host}:{output.contact.port}/"
        code, text = administer(output.contact.address, Bottle([Vocab("add"), place]), None)
        assert code == -1 and "/out cannot send to itself" in text
        assert administer(output.contact.address, Bottle([Vocab("add"), "/out"]), None)[0] == -1
        assert not output.connections
    assert not caplog.records


def test_a_port_sends_to_one_of_another_machine_with_the_same_number(monkeypatch):
    """YARP's ports begin at 10002 on each machine."""
    with OutputPort("/out") as output:
        monkeypatch.setattr(sockets, "local_address_towards", lambda host, port: "192.0.2.1")
        assert not output._is_own(("192.0.2.2", output.contact.port))
        assert output._is_own(("192.0.2.1", output.contact.port))
        assert not output._is_own(("192.0.2.1", output.contact.port + 1))


def test_requests_that_are_refused_do_not_fill_the_log(caplog):
    caplog.set_level("INFO")

    def refuse(request):
        raise UsageError("not like that")

    with RpcServer("/rpc", refuse) as server, RpcClient(server.place()) as client:
        for _ in range(20):
            assert client.call(Bottle(["x"]))[0] == Vocab("fail")
    assert len([text for text in caplog.messages if "not like that" in text]) == 1
