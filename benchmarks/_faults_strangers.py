"""Attacks by a stranger while a camera streams: on YARP, the name server and GigE Vision."""

from __future__ import annotations

import itertools
import multiprocessing
import os
import random
import re
import resource
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field

from benchmarks._faults import Outcome, fault
from grabbergui import sources
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.binary import encode_message
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.carrier import encode_header
from grabbergui.net.yarp.os.link import administer
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.stamp import Stamp
from grabbergui.net.yarp.os.values import Vocab

CHAPTER = "A stranger on the network"
FPS = 25
CAMERA = f"sim:?width=640&height=480&fps={FPS}"
SERVER = "127.15.1.1"
GIGE_CAMERA = "127.15.1.2"
STRANGER = "127.15.1.66"
UNDISTURBED_SECONDS = 3.0
"Seconds before each attack in which the reference rate is measured."
HELD = 0.8
"Part of that rate that must remain; other programs on the machine move it by a tenth."
ATTACK_SECONDS = 10.0
HOSTILE_LINE = b"(" * 60 + b"a " * 450_000 + b")" * 60
"""900 kB; the parser of the first release took 25 s for it."""

LONGEST_LINE = b"(" * 60 + b"a " * 9_900 + b")" * 60
"""Just allowed."""

Address = tuple[str, int]


@contextmanager
def served(*options: str, descriptors: int = 1024) -> Iterator[NameClient]:
    """Run `grabbergui serve` with a name server in a process of its own; yield the address of that."""
    command = [sys.executable, "-m", "grabbergui", "serve", CAMERA, "--yarp", "/cam", *options]
    command += ["--with-name-server", "--nameserver", f"{SERVER}:0"]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors)),
    )
    assert process.stdout is not None
    try:
        found = next(filter(None, (re.search(r"is at (\S+:\d+)", line) for line in process.stdout)))
        while "serving" not in process.stdout.readline():
            pass
        yield NameClient.find(found[1])
        assert process.poll() is None, "the server is gone"
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()


@dataclass
class Watch:
    """Reads the stream as a viewer does, and records when each frame arrived."""

    port: InputPort
    times: list[float] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    closing: threading.Event = field(default_factory=threading.Event)

    def run(self) -> None:
        while not self.closing.is_set():
            with suppress(FrameTimeoutError):
                _, envelope = self.port.read(0.5)
                self.times.append(time.monotonic())
                stamp = Stamp.decode(envelope)
                assert stamp is not None, f"the server's envelope is {envelope!r}"
                self.counts.append(stamp.count)

    def lost(self, begin: float, end: float) -> int:
        """Return the frames, by the server's numbers, that did not arrive between two times."""
        seen = [count for at, count in zip(self.times, self.counts, strict=True) if begin <= at <= end]
        return seen[-1] - seen[0] + 1 - len(seen) if seen else round((end - begin) * FPS)

    def rate(self, begin: float, end: float) -> float:
        return sum(begin <= at <= end for at in self.times) / (end - begin)

    def longest_gap(self, begin: float, end: float) -> float:
        inside = [begin, *(at for at in self.times if begin <= at <= end), end]
        return max(after - before for before, after in itertools.pairwise(inside))

    def well_after(self, end: float) -> float:
        """Return the seconds from `end` to the frame after which no gap exceeds three periods."""
        later = [end, *(at for at in self.times if at > end)]
        late = [after for before, after in itertools.pairwise(later) if after - before > 3 / FPS]
        return late[-1] - end if late else 0.0


@contextmanager
def watched(names: NameClient) -> Iterator[Watch]:
    """Start a viewer of the served camera and wait for its first frames."""
    port = InputPort("/viewer", names)
    with ExitStack() as stack:
        stack.enter_context(port)
        port.connect("/cam", "fast_tcp")
        watch = Watch(port)
        thread = threading.Thread(target=watch.run, name="viewer")
        thread.start()
        try:
            while not watch.times:
                time.sleep(0.05)
            time.sleep(UNDISTURBED_SECONDS)
            yield watch
        finally:
            watch.closing.set()
            thread.join()


@contextmanager
def attacked(attack: Callable[..., None], *arguments: object) -> Iterator[None]:
    """Run `attack(*arguments)` in a process of its own, so that it does not slow the viewer's interpreter."""
    process = multiprocessing.get_context("spawn").Process(target=attack, args=arguments)
    process.start()
    try:
        yield
    finally:
        process.terminate()
        process.join(10)


def connect(address: Address, greeting: bytes) -> socket.socket:
    sock = socket.create_connection(address, 5, source_address=(STRANGER, 0))
    with suppress(OSError):
        sock.sendall(greeting)
    return sock


def streamed_through(watch: Watch, begin: float, end: float) -> tuple[str, str, bool]:
    """Return the lost frames as text, the recovery time, and whether the stream met its promise."""
    lost, rate, gap = watch.lost(begin, end), watch.rate(begin, end), watch.longest_gap(begin, end)
    text = (
        f"{lost} of {round((end - begin) * FPS)} frames; {rate:.1f} frames/s, longest gap {gap * 1000:.0f} ms"
    )
    before = watch.rate(begin - UNDISTURBED_SECONDS, begin)
    return text, f"{watch.well_after(end):.1f} s", rate > HELD * before


def stream_destination(camera: Address) -> Address:
    """Read where a GigE camera sends its stream: SCDA and SCP, which anybody may read."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.settimeout(5)
        sock.sendto(struct.pack(">BBHHHII", 0x42, 1, 0x0080, 8, 1, 0x0D18, 0x0D00), camera)
        host, port = struct.unpack(">4sI", sock.recv(100)[8:16])
    return socket.inet_ntoa(host), port & 0xFFFF


def send_lines(address: Address, line: bytes) -> None:
    """Send a line repeatedly, over a new connection whenever the old one is closed."""
    while True:
        with suppress(OSError), connect(address, b"CONNECT stranger\r\n") as sock:
            while True:
                sock.sendall(b"d\r\n" + line + b"\r\n")
                sock.recv(1 << 20)


def send_lines_eightfold(address: Address, line: bytes) -> None:
    for _ in range(8):
        threading.Thread(target=send_lines, args=(address, line), daemon=True).start()
    time.sleep(600)


def open_many(addresses: list[Address], count: int) -> None:
    """Open this many connections to each port, half of them reversed, and hold them."""
    reader = encode_header(wire.FAST_TCP, "stranger") + b"".join(encode_message("r"))
    held = []
    for number in range(count):
        for address in addresses:
            greeting = reader if number % 2 else b"CONNECT /idle%d\r\n" % number
            with suppress(OSError):
                held.append(connect(address, greeting))
    time.sleep(600)


def send_datagrams(addresses: list[Address], seed: int) -> None:
    """Send random bytes, and GVCP and GVSP headers followed by random bytes."""
    chance = random.Random(seed)
    heads = (b"", b"\x42\x01\x00", b"\x42\x00\x00\x80", b"\x00\x00\x00\x01\x03", b"\x00\x00\x00\x01\x01")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind((STRANGER, 0))
        for number in itertools.count():
            data = chance.choice(heads) + chance.randbytes(chance.randrange(0, 1400))
            with suppress(OSError):
                sock.sendto(data, addresses[number % len(addresses)])
            if number % 20 == 0:
                time.sleep(0.001)


def _lines(line: bytes, what: str) -> Outcome:
    with served() as names, watched(names) as watch:
        begin = time.monotonic()
        with attacked(send_lines_eightfold, names.query("/cam/rpc").address, line):
            time.sleep(ATTACK_SECONDS)
            end = time.monotonic()
        time.sleep(2)
        lost, well, held = streamed_through(watch, begin, end)
    return Outcome(
        f"eight connections to the RPC port send {what}", f"for {ATTACK_SECONDS:.0f} s", lost, well, held
    )


@fault(CHAPTER)
def hostile_lines() -> Outcome:
    return _lines(HOSTILE_LINE, "lines of 900 kB with 60 nested lists")


@fault(CHAPTER)
def longest_lines() -> Outcome:
    return _lines(LONGEST_LINE, "lines as long and as deep as is allowed")


@fault(CHAPTER)
def connection_flood() -> Outcome:
    count = 300
    with served() as names, watched(names) as watch:
        ports = [names.query(name).address for name in ("/cam", "/cam/rpc")]
        begin = time.monotonic()
        with attacked(open_many, ports, count):
            time.sleep(ATTACK_SECONDS)
            with RpcClient("/cam/rpc", names) as newcomer:
                asked = time.monotonic()
                newcomer.call(Bottle([Vocab("fgi"), Vocab("get"), Vocab("w")]))
                answered = time.monotonic() - asked
            end = time.monotonic()
        time.sleep(2)
        lost, well, held = streamed_through(watch, begin, end)
    done = "connections to image and RPC port, half of them registered and idle, half reversed to receive"
    return Outcome(
        done, f"{count} each", f"{lost}; a newcomer is answered in {answered * 1000:.0f} ms", well, held
    )


@fault(CHAPTER)
def descriptor_limit() -> Outcome:
    descriptors, count = 96, 60
    with served(descriptors=descriptors) as names, watched(names) as watch:
        ports = [names.query(name).address for name in ("/cam", "/cam/rpc")]
        begin = time.monotonic()
        with attacked(open_many, ports, count):
            time.sleep(ATTACK_SECONDS)
            end = time.monotonic()
        while True:
            with suppress(Exception):
                administer(ports[1], Bottle([Vocab("ver")]))
                break
            assert time.monotonic() < end + 30, "nobody can connect any more"
        connected = time.monotonic() - end
        time.sleep(1)
        lost, well, held = streamed_through(watch, begin, end)
    done = f"a server that may open {descriptors} descriptors gets more connections than that"
    return Outcome(
        done, f"{2 * count}", f"{lost}; the next peer connects after {connected:.1f} s", well, held
    )


@fault(CHAPTER)
def overwritten_name() -> Outcome:
    waits = []
    with served() as names, watched(names) as watch:
        own = names.query("/cam").address
        begin = time.monotonic()
        for _ in range(2):
            taken = time.monotonic()
            names.register("/cam", "tcp", "192.0.2.66", 666)
            while names.query("/cam").address != own:
                assert time.monotonic() < taken + 60, "the name did not come back"
                time.sleep(0.1)
            waits.append(time.monotonic() - taken)
        lost, _, held = streamed_through(watch, begin, time.monotonic())
    return Outcome(
        "another port registers the camera's name at the name server",
        f"{len(waits)} times",
        f"{lost}; existing connections stay open",
        " and ".join(f"{wait:.1f} s" for wait in waits),
        held,
    )


@fault(CHAPTER)
def hostile_datagrams() -> Outcome:
    with ExitStack() as stack:
        command = [sys.executable, "-m", "grabbergui", "simulate", "--gige", GIGE_CAMERA, "--camera", CAMERA]
        camera = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert camera.stdout is not None
        stack.callback(camera.wait, 10)
        stack.callback(camera.terminate)
        stack.callback(camera.stdout.close)
        assert GIGE_CAMERA in camera.stdout.readline()
        grabber = stack.enter_context(closing(sources.create(f"gige:{GIGE_CAMERA}")))
        grabber.open()
        queue = grabber.open_queue(8)
        grabber.start()
        for _ in range(FPS):
            queue.get(5)
        ends = [(GIGE_CAMERA, 3956), stream_destination((GIGE_CAMERA, 3956))]
        before = grabber.statistics()
        with attacked(send_datagrams, ends, os.getpid()):
            time.sleep(ATTACK_SECONDS)
            after = grabber.statistics()
            asked = time.monotonic()
            grabber.write_feature("Gain", 1.0)
            answered = time.monotonic() - asked
        end = time.monotonic()
        queue.get(5)
        well = time.monotonic() - end
        grabber.stop()
    frames = after.frames - before.frames
    lost = after.lost + after.incomplete - before.lost - before.incomplete
    ignored = after.packets_ignored - before.packets_ignored
    return Outcome(
        "random and almost valid datagrams to a GigE camera's control port and its host's stream port",
        f"{ignored} at the stream port in {ATTACK_SECONDS:.0f} s",
        f"{lost} of {frames + lost} frames; a feature is written in {answered * 1000:.0f} ms",
        f"{well:.1f} s",
        frames > 0.9 * FPS * ATTACK_SECONDS and ignored > 0,
    )
