"""The control link's threads: a camera of a few lines at the other end decides what it answers, and when."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress

import pytest

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
)
from grabbergui.driver.gige import gvcp, privilege
from grabbergui.driver.gige.bootstrap import BootstrapRegister, ControlPrivilege, GvcpCapability
from grabbergui.driver.gige.control_channel import ControlTiming
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.gige.gvcp import Ack, WriteMem, WriteReg
from grabbergui.driver.gige.heartbeat import Pulse
from patience import PATIENCE, TRIES, until

FEATURE = 0x20030
PATIENT = ControlTiming(ack_timeout=PATIENCE, tries=1)
"For what must be answered by the first acknowledge."


class ScriptedCamera:
    """Answers reads of one register; `answers` says for each command, by its address, whether to."""

    def __init__(self, address: str) -> None:
        self.answers: Callable[[int], bool] = lambda address: True
        self.postpones: Callable[[int], bool] = lambda address: False
        "Whether to ask for more time and do nothing."
        self.privilege: int = ControlPrivilege.CONTROL
        "What every register reads as."
        self.reads: list[int] = []
        "Addresses of all commands in the order in which they came."
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((address, 0))
        self.ip, self.port = self._socket.getsockname()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._socket.sendto(b"", (self.ip, self.port))
        self._thread.join()
        self._socket.close()

    def _run(self) -> None:
        while True:
            datagram, client = self._socket.recvfrom(2048)
            if not datagram:
                return
            header, payload = gvcp.split_command(datagram)
            (address, *_) = gvcp.ReadReg.decode(payload).addresses
            self.reads.append(address)
            if self.postpones(address):
                self._socket.sendto(gvcp.encode_pending_ack(1, header.req_id), client)
            elif self.answers(address):
                value = self.privilege.to_bytes(4, "big")
                self._socket.sendto(Ack(0, header.command + 1, header.req_id, value).encode(), client)

    def beats(self) -> int:
        return self.reads.count(BootstrapRegister.CCP)


@pytest.fixture
def camera() -> Iterator[ScriptedCamera]:
    with closing(ScriptedCamera(f"127.11.{os.getpid() % 250 + 1}.1")) as camera:
        yield camera


@pytest.fixture
def link(camera: ScriptedCamera) -> Iterator[ControlLink]:
    with closing(ControlLink(camera.ip, camera.port, PATIENT)) as link:
        yield link


def test_commands_go_on_between_two_beats(camera: ScriptedCamera, link: ControlLink) -> None:
    """The heartbeat's thread once kept the link from one beat to the next: one command a beat got through."""
    link.start_heartbeat(Pulse(period=0.2), controlling=True)
    until(camera.beats, "the first beat")
    while camera.beats() < 3:
        link.read_register(FEATURE)
    first, *others = (at for at, address in enumerate(camera.reads) if address == BootstrapRegister.CCP)
    assert others[-1] - first > 10


def test_a_beat_without_an_answer_does_not_delay_commands(camera: ScriptedCamera, link: ControlLink) -> None:
    camera.answers = lambda address: address != BootstrapRegister.CCP
    link.start_heartbeat(Pulse(period=0.01, timing=PATIENT), controlling=True)
    until(camera.beats, "the first beat")
    for _ in range(20):
        assert link.read_register(FEATURE) == ControlPrivilege.CONTROL
    assert camera.beats() == 1


def test_the_heart_beats_while_a_command_waits_for_its_answer(
    camera: ScriptedCamera, link: ControlLink
) -> None:
    camera.answers = lambda address: address != FEATURE or camera.beats() >= 3
    link.start_heartbeat(Pulse(period=0.01), controlling=True)
    slow = ControlTiming(ack_timeout=0.05, tries=600)
    link.execute(gvcp.ReadReg((FEATURE,)), slow)
    assert camera.beats() >= 3 and link.lost is None


def test_threads_have_equal_shares(camera: ScriptedCamera, link: ControlLink) -> None:
    """A thread that reads register after register leaves room for one command of another between any two."""
    counts = [0, 0, 0]
    enough = threading.Event()

    def read(number: int) -> None:
        while not enough.is_set():
            link.read_register(FEATURE + 4 * number)
            counts[number] += 1

    with ExitStack() as stack:
        stack.callback(enough.set)
        for number in range(len(counts)):
            thread = threading.Thread(target=read, args=(number,))
            thread.start()
            stack.callback(thread.join)
            stack.callback(enough.set)
        shares = [0.0]
        for _ in range(TRIES):  # a busy machine may leave a thread without a core for a while
            before = list(counts)
            until(lambda before=before: sum(counts) - sum(before) > 300, "300 commands")
            shares = [now - then for now, then in zip(counts, before, strict=True)]
            if min(shares) > 50:
                break
    assert min(shares) > 50


def test_closing_ends_a_command_that_waits(camera: ScriptedCamera) -> None:
    camera.answers = lambda address: False
    errors: list[Exception] = []
    link = ControlLink(camera.ip, camera.port, ControlTiming(ack_timeout=0.1, tries=1000))

    def read() -> None:
        try:
            link.read_register(FEATURE)
        except DeviceLostError as error:
            errors.append(error)

    threads = [threading.Thread(target=read) for _ in range(2)]
    for thread in threads:
        thread.start()
    until(lambda: camera.reads, "the command")
    link.close()
    for thread in threads:
        thread.join(PATIENCE)
    assert [str(error) for error in errors] == ["the camera is closed"] * 2


def test_loss_ends_a_command_that_waits(camera: ScriptedCamera, link: ControlLink) -> None:
    camera.answers = lambda address: False
    link.start_heartbeat(Pulse(period=0.01, timing=ControlTiming(0.02, 3)), controlling=True)
    with pytest.raises(DeviceLostError, match="did not answer"):
        link.read_register(FEATURE)


@pytest.mark.parametrize(
    ("privilege", "error"), [(0, DeviceLostError), (ControlPrivilege.CONTROL, AccessDeniedError)]
)
def test_a_write_without_an_answer_asks_who_is_in_control(
    camera: ScriptedCamera, privilege: int, error: type[Exception]
) -> None:
    """Nobody is, after the camera has restarted: it is lost, which the next beat need not find out first."""
    camera.answers = lambda address: address != FEATURE
    losses: list[str] = []
    with closing(ControlLink(camera.ip, camera.port, ControlTiming(ack_timeout=0.5, tries=1))) as link:
        link.on_lost = losses.append
        link.start_heartbeat(Pulse(period=60.0), controlling=True)
        memory = DeviceMemory(link)
        memory.writable = True
        camera.privilege = privilege
        with pytest.raises(error):
            memory.write_register(FEATURE, 1)
        if error is DeviceLostError:
            until(lambda: losses, "the loss")
            assert "has restarted" in losses[0]
        else:
            assert link.lost is None


def test_a_write_that_is_only_put_off_says_so(camera: ScriptedCamera) -> None:
    camera.postpones = lambda address: address == FEATURE
    timing = ControlTiming(ack_timeout=PATIENCE, tries=1, pending_limit=0.1)
    with closing(ControlLink(camera.ip, camera.port, timing)) as link:
        link.start_heartbeat(Pulse(period=60.0), controlling=True)
        memory = DeviceMemory(link)
        memory.writable = True
        with pytest.raises(DeviceStatusError, match="the camera had asked for more time") as refused:
            memory.write_register(FEATURE, 1)
        assert refused.value.status == gvcp.Status.BUSY and link.lost is None


def test_control_that_is_only_put_off_is_not_blamed_on_another_application(camera: ScriptedCamera) -> None:
    """Before, this took twice as long, and asked to close another program."""
    camera.privilege = 0
    camera.postpones = lambda address: address == BootstrapRegister.CCP and camera.beats() > 1
    timing = ControlTiming(ack_timeout=PATIENCE, tries=1, pending_limit=0.1)
    with (
        closing(ControlLink(camera.ip, camera.port, timing)) as link,
        pytest.raises(AckTimeoutError, match="the camera had asked for more time"),
    ):
        privilege.take(link, "the camera", GvcpCapability(0))


@pytest.mark.parametrize("fault", [AckTimeoutError("silent"), DeviceStatusError("refused", 0x8003)])
def test_late_acknowledges_are_switched_on_though_the_first_try_fails(fault: GrabberError) -> None:
    class Link:
        faults = (fault,)

        def __init__(self) -> None:
            self.sent: list[WriteReg | WriteMem] = []

        def read_register(self, register: int) -> int:
            for error in self.faults:
                self.faults = ()
                raise error
            return 0

        def execute(self, request: WriteReg | WriteMem) -> bytes:
            self.sent.append(request)
            return b""

    memory = DeviceMemory(link := Link())  # type: ignore[arg-type]
    memory.capability, memory.writable = GvcpCapability.PENDING_ACK | GvcpCapability.WRITEMEM, True
    switch, write = WriteReg(((BootstrapRegister.GVCP_CONFIGURATION, 2),)), WriteMem(FEATURE, bytes(4))
    with suppress(AckTimeoutError):
        memory.write(FEATURE, bytes(4))
    memory.write(FEATURE, bytes(4))
    assert link.sent == ([switch, write] if isinstance(fault, AckTimeoutError) else [write, write])


class InterruptedLock:
    """A lock that Ctrl-C comes with, at the moment when a thread that has received takes it again."""

    def __init__(self, lock: threading.Lock) -> None:
        self._lock = lock
        self.release = lock.release

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *error: object) -> None:
        self._lock.release()

    def acquire(self) -> None:
        self._lock.acquire()
        raise KeyboardInterrupt


def test_a_command_that_ctrl_c_ends_does_not_hold_up_closing(camera: ScriptedCamera) -> None:
    camera.answers = lambda address: False
    link = ControlLink(camera.ip, camera.port, PATIENT)
    lock = link._lock
    link._lock = InterruptedLock(lock)  # type: ignore[assignment]
    with pytest.raises(KeyboardInterrupt):
        link.read_register(FEATURE)
    link._lock = lock
    closer = threading.Thread(target=link.close, daemon=True)
    closer.start()
    closer.join(PATIENCE)
    assert not closer.is_alive()
