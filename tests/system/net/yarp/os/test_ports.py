"""Ports: images, bottles and requests over every carrier; administration; slow, broken and hostile peers."""

import errno
import re
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing

import numpy as np
import pytest

from grabbergui.core.errors import (
    AckTimeoutError,
    FrameTimeoutError,
    LocalProtocolError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os import ports, sockets
from grabbergui.net.yarp.os.binary import decode_number, encode_message, encode_number
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.carrier import encode_header
from grabbergui.net.yarp.os.events import Header
from grabbergui.net.yarp.os.link import administer, greet
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.outputs import TEXT_LIMIT, Outgoing
from grabbergui.net.yarp.os.ports import InputPort, OutputPort, RpcServer
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.target import Target
from grabbergui.net.yarp.os.values import Dialect, Vocab, Vocab64
from patience import PATIENCE, attempts, until
from yarp_bytes import reply_to

pytestmark = pytest.mark.usefixtures("no_thread_is_left")


def echo(request):
    return Bottle([Vocab("ok"), *request.bottle()])


IMAGE = np.random.default_rng(1).integers(0, 255, (48, 66, 3), np.uint8)


@pytest.mark.parametrize("carrier", ["tcp", "fast_tcp", "udp", "mcast", "mjpeg", "unix_stream"])
def test_images_over_every_carrier(names, carrier):
    with OutputPort("/out", names) as output, InputPort("/in", names) as reader:
        reader.connect("/out", carrier)
        until(lambda: output.connections and reader.sources, "the connection")
        stamp = Stamp(7, 1234.5).encode()
        smooth = np.full_like(IMAGE, 90)
        output.write(*image.encode(smooth, "rgb"), stamp)
        payload, envelope = reader.read(PATIENCE)
        header, pixels = image.decode(payload)
        assert (header.code, envelope) == ("rgb", stamp)
        np.testing.assert_allclose(pixels, smooth, atol=3 if carrier == "mjpeg" else 0)
        reader.disconnect("/out")
        until(lambda: not output.connections, "the end of the connection")


@pytest.mark.parametrize("carrier", ["tcp", "fast_tcp", "udp", "mcast", "unix_stream", "text", "text_ack"])
def test_bottles_over_every_carrier(names, carrier):
    with OutputPort("/out", names) as output, InputPort("/in", names) as reader:
        reader.connect("/out", carrier)
        until(lambda: output.connections and reader.sources, "the connection")
        assert reader.carriers(outgoing=False) == {"/out": carrier}
        bottle = Bottle([1, 2.5, "two words", ["x", Vocab("ok")]])
        output.write_bottle(bottle, "3 4.5")
        payload, envelope = reader.read(PATIENCE)
        assert Bottle.decode(payload) == bottle and envelope == "3 4.5"


def test_readers_over_mcast_share_one_stream_and_its_group_is_given_up(names):
    with (
        OutputPort("/out", names) as output,
        InputPort("/a", names) as first,
        InputPort("/b", names) as second,
    ):
        for reader in (first, second):
            reader.connect("/out", "mcast")
        until(lambda: first.sources and second.sources, "the connections")
        groups = [contact for contact in names.list("/tmp") if contact.carrier == "mcast"]
        assert len(groups) == 1 and groups[0].host.startswith("224.")
        output.write_bottle(Bottle([1]), "1 1.5")
        assert [reader.read(PATIENCE)[1] for reader in (first, second)] == ["1 1.5"] * 2
        first.disconnect("/out")
        until(lambda: output.connections == 1, "the end of one connection")
        output.write_bottle(Bottle([2]), "2 2.5")
        assert second.read(PATIENCE)[1] == "2 2.5", "the other output sends now"
        with pytest.raises(FrameTimeoutError):
            first.read(0)
    assert names.list("/tmp") == []


@pytest.mark.parametrize("carrier", ["fast_tcp", "udp", "unix_stream"])
def test_mono_images_with_recv_bayer_arrive_as_a_bayer_pattern(names, carrier):
    with OutputPort("/out", names) as output, InputPort("/in", names) as reader:
        reader.connect("/out", f"{carrier}+recv.bayer+order.BGGR")
        until(lambda: reader.sources, "the connection")
        assert reader.carriers(outgoing=False) == {"/out": f"{carrier}+recv.bayer+order.BGGR"}
        pattern = np.arange(96, dtype=np.uint8).reshape(6, 16)
        output.write(*image.encode(pattern, "mono"))
        header, pixels = image.decode(reader.read(PATIENCE)[0])
        assert header.code == "bggr" and np.array_equal(pixels, pattern)


@pytest.mark.parametrize(
    ("modifiers", "reason"),
    [
        ("recv.portmonitor+type.dll", r"plug-in portmonitor is not supported, connect without \+recv"),
        ("recv.bayer+order.rgbg", "there is no order rgbg, only grbg, bggr, gbrg, rggb"),
    ],
)
def test_a_plug_in_that_a_reader_lacks_refuses_the_connection(names, caplog, modifiers, reason):
    with OutputPort("/out", names) as output, InputPort("/in", names):
        answer = administer(output.contact.address, Bottle([Vocab("add"), f"tcp+{modifiers}://in"]))
        assert answer[0] == -1 and f"Cannot connect to tcp+{modifiers}://in" in answer[1]
        assert not output.connections
        until(lambda: re.search(reason, caplog.text), "the reason in the reader's log")


def test_a_plug_in_that_the_sender_lacks_changes_nothing_as_in_yarp(names, caplog):
    carrier = "tcp+send.portmonitor+type.dll+file.depthimage_to_mono"
    with OutputPort("/out", names) as output, InputPort("/in", names) as reader:
        added = administer(output.contact.address, Bottle([Vocab("add"), f"{carrier}://in"]))
        assert added == [0, f"Added connection from /out to {carrier}://in\r\n"]
        until(lambda: reader.sources, "the connection")
        listed = administer(output.contact.address, Bottle([Vocab("list"), Vocab("out"), "/in"]))
        assert listed.find("carrier") == carrier
        output.write_bottle(Bottle([1]))
        assert Bottle.decode(reader.read(PATIENCE)[0]) == [1]
    assert "/out: there is no plug-in portmonitor: /in gets messages unchanged" in caplog.text


def test_a_request_of_any_size_gets_its_reply(names):
    with RpcServer("/rpc", echo, names), RpcClient("/rpc", names) as client:
        assert client.call(Bottle([1, "a"])) == [Vocab("ok"), 1, "a"]
        big = Bottle([bytes(3_000_000)])
        assert len(client.call(big)[1]) == 3_000_000


def test_replies_are_written_in_the_dialect_of_the_request():
    with RpcServer("/rpc", echo) as server, RpcClient(server.place()) as client:
        for dialect in Dialect:
            client.dialect = dialect
            assert client.call(Bottle([2.5])) == [Vocab("ok"), 2.5]
            sent = Bottle([2.5]).encode(dialect, specialise=dialect is Dialect.YARP3)
            assert reply_to((server.contact.host, server.contact.port), sent) == Bottle(
                [Vocab("ok"), 2.5]
            ).encode(dialect)


def test_no_reply_is_an_acknowledgement_alone():
    with RpcServer("/rpc", lambda request: None) as server, RpcClient(server.place()) as client:
        assert client.call(Bottle([1])) is None
        assert reply_to((server.contact.host, server.contact.port), Bottle([1]).encode()) == b""


def test_a_client_comes_back_after_its_server(names):
    client = RpcClient("/rpc", names)
    with closing(client):
        for _ in range(2):
            with RpcServer("/rpc", echo, names):
                assert client.call(Bottle([1])) == [Vocab("ok"), 1]


def test_an_answer_that_never_comes():
    release = threading.Event()
    with (
        RpcServer("/rpc", lambda request: release.wait(PATIENCE) and None) as server,
        RpcClient(server.place()) as client,
    ):
        with pytest.raises(AckTimeoutError, match="in time"):
            client.call(Bottle([1]), timeout=0.1)
        release.set()


def test_closing_a_client_ends_the_call_that_waits_and_the_next_one_connects_again():
    asked, release = threading.Event(), threading.Event()

    def answer(request):
        asked.set()
        return release.wait(PATIENCE) and echo(request)

    with RpcServer("/rpc", answer) as server, ThreadPoolExecutor() as pool:
        client = RpcClient(server.place())
        for watch in attempts(0.3):
            asked.clear()
            call = pool.submit(client.call, Bottle([1]), PATIENCE)
            assert asked.wait(PATIENCE)
            with watch:
                client.close()
                error = call.exception(PATIENCE)
            assert isinstance(error, TransportError) and "closed here" in str(error)
        release.set()
        with closing(client):
            assert client.call(Bottle([2])) == [Vocab("ok"), 2]


def test_a_source_that_hangs_does_not_hold_up_the_end_of_its_reader(names):
    """As one that was stopped in a debugger: the system accepts for it, and nobody answers."""
    with socket.create_server(("127.0.0.1", 0)) as silent:
        names.register("/silent", "tcp", *silent.getsockname())
        for watch in attempts(ports.PARTING_SECONDS + 0.1):
            reader = InputPort("/in", names)
            reader.open()
            link, _ = greet(sockets.connect(reader.contact.address), Header(wire.FAST_TCP, "/silent"))
            until(lambda reader=reader: "/silent" in reader.sources, "the connection")
            with watch:
                reader.close()
            link.close()
            with pytest.raises(SourceNotFoundError):
                names.query("/in")


def test_udp_readers_are_notified_of_the_end_at_the_same_time(names, monkeypatch):
    """One after another, each that hangs would hold up the end of its source."""
    together = threading.Barrier(4)
    monkeypatch.setattr("grabbergui.net.yarp.os.port.report_end", lambda *_: together.wait(PATIENCE / 4))
    with OutputPort("/out", names) as output, ExitStack() as stack:
        for number in range(together.parties):
            reader = stack.enter_context(InputPort(f"/in{number}", names))
            reader.connect("/out", "udp")
        output.close()
        assert not output.connections and not together.broken


def test_udp_readers_hear_of_the_end_though_the_name_server_is_gone():
    with NameServer(port=0) as server, InputPort("/in", NameClient(server.contact)) as reader:
        with OutputPort("/out", NameClient(server.contact)) as output:
            reader.connect("/out", "udp")
            until(lambda: reader.sources, "the connection")
            server.close()
            output.close()
        until(lambda: not reader.sources, "the end of the connection")


def test_a_port_that_hangs_or_is_gone_is_named(names):
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = silent.getsockname()
        names.register("/rpc", "tcp", *address)
        with pytest.raises(
            AckTimeoutError, match=f"/rpc at 127.0.0.1:{address[1]} does not answer; its program"
        ):
            RpcClient("/rpc", names).call(Bottle([1]), timeout=0.1)
    gone = (
        f"/rpc: nothing answers at 127.0.0.1:{address[1]}: .*; the name server lists it, but its program has"
    )
    with pytest.raises(TransportError, match=gone):
        RpcClient("/rpc", names).call(Bottle([1]))


def test_a_port_that_sends_nothing_is_no_source(names):
    refused = pytest.raises(TransportError, match="/rpc is no port of images: it sends nothing")
    with RpcServer("/rpc", echo, names), InputPort("/in", names) as reader, refused:
        reader.connect("/rpc")


def test_a_broken_request_hurts_its_own_connection_only():
    with RpcServer("/rpc", echo) as server, RpcClient(server.place()) as client:
        (refusal,) = client.call(bytes.fromhex("000100000100000005000000"))[:1]
        assert refusal == Vocab("fail")
        assert client.call(Bottle([1])) == [Vocab("ok"), 1]


def test_a_carrier_or_plug_in_that_is_refused_is_named_in_the_log_once(names, caplog):
    with OutputPort("/out", names) as output, InputPort("/in", names):
        for target in ("shmem://in", "mjpeg+recv.portmonitor://in", "shmem://in", "/nosuch"):
            administer(output.contact.address, Bottle([Vocab("add"), target]))

    warned = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert len(warned) == 2
    assert "/out: no connection to shmem://in: carrier shmem is not supported" in warned[0]
    assert "portmonitor must run at the other end" in warned[1]


def test_administrative_commands_are_answered_as_yarp_does(names):
    with OutputPort("/out", names) as output, InputPort("/in", names) as reader:
        ask = lambda *items: administer(output.contact.address, Bottle(items))  # noqa: E731
        assert ask(Vocab("ver")) == [Vocab("ver"), 1, 2, 3]
        assert ask(Vocab("list"), Vocab("out")) == []
        assert ask(Vocab("add"), "fast_tcp://in") == [0, "Added connection from /out to fast_tcp://in\r\n"]
        assert ask(Vocab("list"), Vocab("out")) == ["/in"]
        assert ask(Vocab("list"), Vocab("out"), "/in").find("carrier") == "fast_tcp"
        until(lambda: reader.sources == ["/out"])
        assert ask(Vocab("del"), "/in") == [0, "Removed connection from /out to /in\r\n"]
        assert ask(Vocab("del"), "/in")[0] == -1
        assert ask(Vocab("add"), "/nosuch") == [-1, "Do not know how to connect to /nosuch\r\n"]
        assert "shmem is not supported" in ask(Vocab("add"), "shmem://in")[1]
        assert ask("prop", "set", "a", 5) == [Vocab("ok")] and ask("prop", "get", "a") == [5]
        assert ask("prop", "set", "b", "x" * 5000)[0] == Vocab("fail")
        assert ask("nonsense")[0] == Vocab("fail")
        assert administer(reader.contact.address, Bottle([Vocab("add"), "/out"]))[0] == -1


def test_a_property_that_yarp_3_cannot_express_is_refused():
    """It would break every list of the properties, which any peer may request."""
    with OutputPort("/out") as output:
        vocab64 = [Vocab("prop"), Vocab("set"), "a", Vocab64("longword")]
        assert output.commands.administer(vocab64)[0] == Vocab("fail")
        assert administer(output.contact.address, Bottle(["prop", "get"])) == []


def test_a_slow_reader_slows_nobody():
    with (
        OutputPort("/out") as output,
        InputPort("/in") as reader,
        socket.create_server(("127.0.0.1", 0)) as lazy,
    ):

        def never_read():
            sock, _ = lazy.accept()
            sock.recv(64)
            sock.sendall(encode_number(1))
            return sock

        accepted = []
        thread = threading.Thread(target=lambda: accepted.append(never_read()))
        thread.start()
        output.add(Target.parse(f"fast_tcp://127.0.0.1:{lazy.getsockname()[1]}/"))
        thread.join()
        output.add(Target.parse(f"tcp://127.0.0.1:{reader.port_number}/"))
        message = image.encode(np.zeros((1000, 1000, 3), np.uint8), "rgb")
        for number in range(20):
            output.write(*message, Stamp(number, 1).encode())
            assert Stamp.decode(reader.read(PATIENCE)[1]).count == number
        assert output.dropped > 5
        accepted[0].close()


def test_a_message_that_waits_for_a_slow_reader_is_waited_for_until_it_is_taken():
    with (
        OutputPort("/out") as output,
        socket.create_server(("127.0.0.1", 0)) as lazy,
        ThreadPoolExecutor(2) as pool,
    ):
        assert output.wait_sent(0), "without readers nothing waits"
        reader = Target.parse(f"fast_tcp://127.0.0.1:{lazy.getsockname()[1]}/")
        adding = pool.submit(output.add, reader)
        sock, _ = lazy.accept()
        with sock:
            sock.recv(64)
            sock.sendall(encode_number(1))
            adding.result(PATIENCE)
            output.write(bytes(1 << 25))  # more than the system buffers
            until(lambda: output.wait_sent(0))
            output.write_bottle(Bottle([1]))
            assert not output.wait_sent(0.05)
            waiting, begun = pool.submit(output.wait_sent, PATIENCE / 2), time.monotonic()
            pool.submit(lambda: [... for _ in iter(lambda: sock.recv(1 << 20), b"")])
            assert waiting.result() and time.monotonic() - begun < PATIENCE / 2
            output.close()


def test_a_message_is_compressed_once_for_all_readers_and_refused_as_text_if_too_long():
    message = Outgoing(image.encode(IMAGE, "rgb"), "1 2")
    assert message.jpeg() is message.jpeg()
    assert message.text() is message.text()
    with pytest.raises(
        LocalProtocolError, match=rf"a message of {TEXT_LIMIT + 1} bytes is too long for text"
    ):
        Outgoing([bytes(TEXT_LIMIT + 1)]).text()


@pytest.mark.parametrize(("carrier", "greeting"), [("text", b"CONNECT"), ("text_ack", b"CONNACK")])
def test_a_text_reader_gets_images_of_any_size_in_numbers(carrier, greeting):
    """As from a YARP port: somebody may look at it."""
    pixels = np.arange(300 * 400 * 3, dtype=np.uint32).astype(np.uint8).reshape(300, 400, 3)
    with OutputPort("/out") as output, socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(PATIENCE)
        with ThreadPoolExecutor(1) as pool:
            place = f"{carrier}://127.0.0.1:{server.getsockname()[1]}/"
            adding = pool.submit(output.add, Target.parse(place))
            sock, _ = server.accept()
            with closing(sock), sock.makefile("rb") as lines:
                assert lines.readline() == greeting + b" /out\r\n"
                sock.sendall(b"Welcome /out\r\n")
                adding.result(PATIENCE)
                for number in range(2):
                    output.write(*image.encode(pixels, "rgb"), f"{number} 2.5")
                    assert lines.readline() == f"D {number} 2.5\r\n".encode()
                    header, _, numbers = lines.readline().partition(b" {")
                    assert header == b"[mat] [rgb] (3 360000 8 400 300)"
                    assert bytes(map(int, numbers.rstrip(b"}\r\n").split())) == pixels.tobytes()
                    if carrier == "text_ack":
                        sock.sendall(b"<ACK>\r\n")


def test_only_the_newest_is_kept_for_a_slow_owner():
    with OutputPort("/out") as output, InputPort("/in") as reader:
        output.add(Target.parse(f"tcp://127.0.0.1:{reader.port_number}/"))
        for number in range(5):
            output.write_bottle(Bottle([number]))
            until(lambda sent=number + 1: output._registry.outputs[0].messages == sent)
        assert Bottle.decode(reader.read(PATIENCE)[0]) == [4] and reader.overwritten == 4
        with pytest.raises(FrameTimeoutError):
            reader.read(0.01)


def test_reading_in_reverse_without_a_name():
    with OutputPort("/out") as output, socket.create_connection(output.contact.address) as sock:
        sock.settimeout(PATIENCE)
        sock.sendall(encode_header(wire.FAST_TCP, "/me"))
        assert decode_number(sock.recv(8)) == output.port_number
        sock.sendall(b"".join(encode_message("r")))
        until(lambda: output.connections)
        output.write_bottle(Bottle(["hello"]))
        assert Bottle(["hello"]).encode() in sock.recv(4096)


GARBAGE = [
    b"\xff" * 64,
    b"YA\xe4\x1e\x00\x00RP\xff\xff\xff\x7f",
    encode_header(wire.TCP, "/x") + b"".join(encode_message("d"))[:20],
    encode_header(wire.TCP, "/x")
    + encode_number(10)
    + b"\x01\x01"
    + b"\xff" * 8
    + b"\xff\xff\xff\x7f\0\0\0\0",
    b"CONNECT x\r\nd\r\n((((((\r\n",
    b"CONNACK " + b"y" * 2_000_000,
    b"GET /?action=stream",
    b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 1000,
    b"GET /" + b"x" * 100_000,
    b"GET / HTTP/1.1\r\n",
    b"UNIX_STR",
    encode_number(7777 + 14),
]


@pytest.mark.parametrize("data", GARBAGE)
def test_garbage_closes_its_connection_and_nothing_else(data, monkeypatch):
    with RpcServer("/rpc", echo) as server, RpcClient(server.place()) as client:
        assert client.call(Bottle([1]))
        monkeypatch.setattr("grabbergui.net.yarp.os.inputs.STALL_SECONDS", 0.3)
        with socket.create_connection(server.contact.address) as sock:
            sock.settimeout(PATIENCE)
            try:
                sock.sendall(data)
                while sock.recv(4096):
                    pass
            except ConnectionError:
                pass
        assert client.call(Bottle([1])) == [Vocab("ok"), 1]


def test_authentication_keeps_strangers_out(monkeypatch):
    server = RpcServer("/rpc", echo)
    server.key = b"secret"
    with server:
        with RpcClient(server.place(), key=b"secret") as friend:
            assert friend.call(Bottle([1])) == [Vocab("ok"), 1]
        monkeypatch.setattr("grabbergui.net.yarp.os.inputs.STALL_SECONDS", 0.3)
        with RpcClient(server.place()) as stranger, pytest.raises(TransportError):
            stranger.call(Bottle([1]), timeout=2)


def test_a_port_that_finds_no_descriptor_for_its_own_use_leaves_nothing_open(monkeypatch):
    port = OutputPort("/out", port=0)

    def exhausted():
        raise OSError(errno.EMFILE, "Too many open files")

    with monkeypatch.context() as patched, pytest.raises(TransportError, match="ulimit -n"):
        patched.setattr(socket, "socketpair", exhausted)
        port.open()
    with port:  # as if nothing had happened
        assert administer(port.contact.address, Bottle([Vocab("ver")]))


def test_a_sender_whose_name_looks_like_an_address_does_not_keep_a_port_from_closing():
    with InputPort("/in") as port, socket.create_connection(port.contact.address) as sock:
        greet(sock, Header(wire.TCP, "//nowhere"))
        until(lambda: port.sources == ["//nowhere"], "connection of the sender")


def test_a_reader_connected_while_the_port_closes_is_disconnected(monkeypatch):
    connect, begun, go_on = sockets.connect, threading.Event(), threading.Event()

    def slow_connect(*arguments, **options):
        begun.set()
        assert go_on.wait(PATIENCE)
        return connect(*arguments, **options)

    with InputPort("/in") as reader, ThreadPoolExecutor(1) as pool:
        source = OutputPort("/out")
        source.open()
        monkeypatch.setattr(sockets, "connect", slow_connect)
        adding = pool.submit(source.add, Target.parse(reader.place()))
        assert begun.wait(PATIENCE)
        source.close()
        go_on.set()
        with pytest.raises(TransportError, match="the port was closed"):
            adding.result(PATIENCE)
        assert not source.connections
        until(lambda: not reader.sources, "end of the connection")
