"""Both ends of a YARP connection in memory, and a message's bytes, written out by hand."""

from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.connection import Phase, Wait, YarpConnection
from grabbergui.net.yarp.os.events import Header, HeaderReply

BOTTLE = Bottle([1, "two", 2.5])
BINARY = memoryview(BOTTLE.encode())
INDEX = b"YA\x0a\0\0\0RP"
D = b"\0\0\0\0~d\0\1"


def message(*blocks):
    """The bytes of a message, written out here rather than by the code that is tested."""
    body = b"".join(blocks)
    start = INDEX + bytes((len(blocks), 1)) + b"\xff" * 8
    sizes = b"".join(len(block).to_bytes(4, "little") for block in blocks)
    return start + sizes + bytes(4) + body


def arriving(connection, data, step=1 << 20):
    """The events that bytes complete; in pieces, none of them early by a byte."""
    found = []
    for start in range(0, len(data), step):
        assert start == 0 or connection.phase is not Phase.ERROR
        connection.receive_data(data[start : start + step])
        while not isinstance(event := connection.next_event(), Wait):
            found.append(event)
    return found


def ready(carrier=wire.TCP, **options):
    opener, acceptor = YarpConnection(opener=True), YarpConnection(opener=False, **options)
    arriving(acceptor, b"".join(opener.send(Header(carrier, "/a"))))
    arriving(opener, b"".join(acceptor.send(HeaderReply(1))))
    return opener, acceptor
