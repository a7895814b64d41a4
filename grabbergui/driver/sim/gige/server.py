"""The simulated camera as a GigE Vision device on UDP, for `grabbergui simulate --gige`."""

from __future__ import annotations

import heapq
import itertools
import logging
import selectors
import socket
import threading
import time
from collections.abc import Callable, Mapping, Sequence

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.driver.gige import bootstrap
from grabbergui.driver.gige.bootstrap import GVCP_PORT, IpConfigurationBit, ip_number, ip_text
from grabbergui.driver.gige.interfaces import Interface, interface_of
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import EVENT_ID_BASE, EventSelector, TransportLayer
from grabbergui.driver.sim.file_store import FileStore
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.control import ControlResponder, OutgoingDatagram
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.gige.faults import GigeFaults
from grabbergui.driver.sim.gige.stream import REBOOT_S, StreamSender, StreamSettings
from grabbergui.driver.sim.memory import Register, RegisterMemory, RegisterValue
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.scene import Scene
from grabbergui.driver.sim.timing import SimulatedClock

log = logging.getLogger(__name__)

GIGABIT = 125e6
"Bytes per second of the link that most cameras have."
_PAYLOAD_SHARE = 0.96
"Share of a link's bytes left for pixels, the rest being headers; keeps the stream from falling behind."
_TICK_S = 0.1
_BURST = 64
"Datagrams taken before anything else is looked after."
_LARGEST_DATAGRAM = 65_535


class GigeCamera:
    """One camera at one address: a control thread and a stream thread. `close` ends both."""

    def __init__(
        self,
        address: str,
        *,
        power_on: Mapping[Register, RegisterValue] | None = None,
        scene: Scene | None = None,
        faults: GigeFaults | None = None,
        deviations: Deviations | None = None,
        bandwidth: float = GIGABIT,
        segmentation: bool = False,
        on_sent: Callable[[int], None] = lambda block_id: None,
        drift: float = 0.0,
    ) -> None:
        """Bind the address and begin to answer. Raises SourceUnavailableError if it is not available.

        `bandwidth` (bytes per second) is the capacity of the camera's link: packets are spread over time and
        the frame rate is limited as on such a link; 0 sends as fast as this machine can. With
        `segmentation` the kernel cuts packets out of large sends, which is faster; packet sockets and
        captures on this machine then see the large sends instead of the packets. `on_sent` is called with a
        block's id when its last payload packet has left, on the stream's thread. `drift` is the part by which
        the camera's clock is fast, without PTP.
        """
        self.address = address
        # Locally administered; both stay the camera's own when it moves to another address.
        self.mac = b"\x02G" + socket.inet_aton(address)
        self._power_on = {reg.DEVICE_SERIAL_NUMBER: reg.serial_at(address), **(power_on or {})}
        self._power_on[reg.DEVICE_TL_TYPE] = int(TransportLayer.GIGE_VISION)
        if bandwidth:
            self._power_on[reg.DEVICE_LINK_SPEED] = max(int(bandwidth), 1)
            self._power_on.setdefault(reg.LINK_THROUGHPUT_LIMIT_MODE, 1)
            self._power_on.setdefault(reg.LINK_THROUGHPUT_LIMIT, max(int(bandwidth * _PAYLOAD_SHARE), 1))
        self._scene = scene
        self._faults = faults or GigeFaults()
        self._deviations = deviations or Deviations()
        self._bandwidth = bandwidth
        self._segmentation = segmentation
        self._on_sent = on_sent
        self._drift = drift
        self._wired: list[GigeCamera] = []
        "Cameras whose Line1 is connected to our Line2."
        self._flash: dict[Register, RegisterValue] = {}
        self._files = FileStore()
        self._queue: list[tuple[float, int, OutgoingDatagram]] = []
        self._order = itertools.count()
        # Reentrant: a command may raise an event.
        self._channel = threading.RLock()
        self._closing = threading.Event()
        self._reboot_at = time.monotonic() + self._faults.reboot_after if self._faults.reboot_after else None
        self._switch_on()
        self._thread = threading.Thread(target=self._run, name=f"camera {address}", daemon=True)
        self._thread.start()

    @property
    def serial(self) -> str:
        """The camera's serial number."""
        return str(self.model.memory.get(reg.DEVICE_SERIAL_NUMBER))

    @property
    def stream_bytes(self) -> int:
        """Payload bytes sent since power-on."""
        return self._stream.sent_bytes

    def stream_to(self, host: str, port: int, packet_size: int) -> None:
        """Send the stream there, as if a controller had set it so."""
        self._stream.configure([StreamSettings(host, port, packet_size)])

    def wire_to(self, other: GigeCamera) -> None:
        """Connect our output Line2 to the input Line1 of another camera, or our own."""
        self._wired.append(other)

    def _put_out(self, high: bool, at: int) -> None:
        for other in self._wired:
            other.model.set_input(high, at)

    def close(self) -> None:
        """Switch the camera off. May be called twice."""
        self._closing.set()
        self._thread.join()

    def _switch_on(self) -> None:
        self.address = self._address_at_power_on()
        interface = interface_of(self.address)
        try:
            self._sockets = _open_sockets(interface, self.address)
        except OSError as error:
            raise SourceUnavailableError(
                f"no camera can listen at {self.address}:{GVCP_PORT}: {error.strerror}; is another one there?"
            ) from error
        self.model = self._make_model()
        memory = self._make_bootstrap(interface)
        for register, value in self._flash.items():
            memory.set(register, value)
        self._stream = StreamSender(
            self.model,
            self.address,
            self._faults,
            self._bandwidth,
            segmentation=self._segmentation,
            on_sent=self._on_sent,
        )
        self._report_source_port(memory)
        self.control = self._make_control(memory)
        self.control.largest_packet = min(interface.mtu, _LARGEST_DATAGRAM) & ~3
        self.control.on_resend = self._stream.resend
        self.control.on_test_packet = self._stream.send_test_packet
        self.control.on_stream_changed = self._configure_stream
        self.control.on_force_ip = self._move
        self.model.on_event = self._send_event
        self.model.on_output = self._put_out
        self.model.on_reset = lambda: self.control.after_ack(self.control.release)
        self._stream.start()

    def _make_model(self) -> CameraModel:
        model = CameraModel(
            scene=self._scene,
            power_on=self._power_on,
            clock=SimulatedClock(drift=self._drift),
            files=self._files,
        )
        model.sensor.scene.prepare()
        return model

    def _make_bootstrap(self, interface: Interface) -> RegisterMemory:
        memory = gev.make_bootstrap(self.model, self.address, interface.netmask, self.mac, self._deviations)
        if self._bandwidth:
            memory.set(gev.LINK_SPEED, max(int(self._bandwidth * 8 / 1e6), 1))
        return memory

    def _make_control(self, memory: RegisterMemory) -> ControlResponder:
        return ControlResponder(self.model, memory, self._deviations)

    def _address_at_power_on(self) -> str:
        """Return the persistent address if it is enabled and available; else the present one."""
        ways = int(self._flash.get(gev.IP_CONFIGURATION, 0))
        wanted = int(self._flash.get(gev.PERSISTENT_IP, 0))
        if not ways & IpConfigurationBit.PERSISTENT or not wanted:
            return self.address
        address = ip_text(wanted)
        try:
            _open_socket(address, shared=False).close()
        except OSError as error:
            log.warning("camera %s cannot have its persistent address %s: %s", self.address, address, error)
            return self.address
        return address

    def _switch_off(self) -> None:
        memory = self.control.memory
        self._flash = {register: memory.stored(register) for register in gev.IN_FLASH}
        self.model.on_event = None
        self.model.stop()
        self._stream.close()
        for sock in self._sockets:
            sock.close()

    def cut_power(self) -> None:
        """Lose and regain the power at once; the camera is back after `REBOOT_S`. Any thread."""
        self._reboot_at = time.monotonic()

    def _reboot(self) -> None:
        """Stop answering for a while, then start again as after power-on."""
        self._reboot_at = None
        self._switch_off()
        self._queue.clear()
        log.info("camera %s reboots", self.address)
        self._closing.wait(REBOOT_S)
        if not self._closing.is_set():
            self._switch_on()

    def _move(self, ip: str, netmask: str) -> bool:
        """Take another address, as FORCEIP asks; the acknowledge leaves from there."""
        try:
            sockets = _open_sockets(interface_of(ip), ip)
        except OSError as error:
            log.info("camera %s cannot move to %s: %s", self.address, ip, error)
            return False
        for sock in self._sockets:
            sock.close()
        self._sockets = sockets
        self.address = ip
        self.control.memory.set(gev.CURRENT_IP, ip_number(ip))
        self.control.memory.set(gev.SUBNET_MASK, ip_number(netmask))
        self._stream.move(ip)
        self._report_source_port(self.control.memory)
        return True

    def _run(self) -> None:
        while not self._closing.is_set():
            sockets = self._sockets
            with selectors.DefaultSelector() as selector:
                for sock in sockets:
                    selector.register(sock, selectors.EVENT_READ)
                while not self._closing.is_set() and self._sockets is sockets:
                    self._turn(selector)
                    if self._reboot_at is not None and time.monotonic() >= self._reboot_at:
                        break
            if self._reboot_at is not None and time.monotonic() >= self._reboot_at:
                self._reboot()
        self._switch_off()

    def _turn(self, selector: selectors.BaseSelector) -> None:
        """Receive the waiting datagrams, and send those that are due."""
        wait = _TICK_S
        if self._queue:
            wait = min(wait, max(self._queue[0][0] - time.monotonic(), 0))
        for key, _ in selector.select(wait):
            if key.fileobj in self._sockets:  # a FORCEIP among the received datagrams closes them all
                self._receive(key.fileobj)
        now = time.monotonic()
        with self._channel:
            self._enqueue(self.control.poll(now))
        while self._queue and self._queue[0][0] <= now:
            self._transmit(heapq.heappop(self._queue)[2])

    def _receive(self, sock: socket.socket) -> None:
        for _ in range(_BURST):
            if sock not in self._sockets:
                return
            try:
                datagram, source = sock.recvfrom(2048)
            except (BlockingIOError, ConnectionRefusedError, InterruptedError):
                return
            now = time.monotonic()
            with self._channel:
                self._enqueue(self.control.receive(datagram, source, now))
            while self._queue and self._queue[0][0] <= now:
                self._transmit(heapq.heappop(self._queue)[2])
            self.control.run_deferred()

    def _enqueue(self, outgoing: Sequence[OutgoingDatagram]) -> None:
        for out in outgoing:
            heapq.heappush(self._queue, (out.due + self._faults.delay, next(self._order), out))

    def _transmit(self, out: OutgoingDatagram) -> None:
        try:
            self._sockets[0].sendto(out.datagram, out.to)
        except OSError as error:
            # A broadcast from a network that this camera is not in.
            log.debug("camera %s cannot answer %s: %s", self.address, out.to, error)

    def _send_event(self, event: EventSelector, frame_id: int, timestamp: int) -> None:
        # Comes from either thread; the repeats are the control thread's.
        with self._channel:
            messages = self.control.send_event(EVENT_ID_BASE + event, frame_id, timestamp, time.monotonic())
        for out in messages:
            self._transmit(out)

    def _configure_stream(self) -> None:
        memory = self.control.memory
        extended = bool(memory.integer(gev.GVSP_CONFIGURATION) & bootstrap.GvspConfiguration.EXTENDED_IDS)
        self._stream.configure(
            [
                StreamSettings(
                    ip_text(memory.integer(channel.scda)),
                    memory.integer(channel.scp) & bootstrap.PORT_MASK,
                    memory.integer(channel.scps) & bootstrap.PACKET_SIZE_MASK,
                    memory.integer(channel.scpd),
                    extended,
                )
                for channel in gev.CHANNELS
            ]
        )

    def _report_source_port(self, memory: RegisterMemory) -> None:
        for channel in gev.CHANNELS:
            memory.set(channel.scsp, self._stream.port)


def _open_sockets(interface: Interface, address: str) -> list[socket.socket]:
    """Open the camera's own socket, then those for broadcasts, which Linux passes to no other."""
    sockets = [_open_socket(address, shared=False)]
    for broadcast in ("255.255.255.255", interface.broadcast):
        if broadcast == address:
            continue
        try:
            sockets.append(_open_socket(broadcast, shared=True))
        except OSError as error:
            log.debug("camera %s does not hear broadcasts to %s: %s", address, broadcast, error)
    return sockets


def _open_socket(address: str, *, shared: bool) -> socket.socket:
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        if shared:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        sock.bind((address, GVCP_PORT))
        sock.setblocking(False)
    except OSError:
        sock.close()
        raise
    return sock


def serve(
    addresses: Sequence[str] = ("127.0.0.1",),
    *,
    serial: str = "",
    power_on: Mapping[Register, RegisterValue] | None = None,
    scene: Callable[[], Scene] | None = None,
    faults: GigeFaults | None = None,
    deviations: Deviations | None = None,
    bandwidth: float = GIGABIT,
    segmentation: bool = False,
    wires: Sequence[tuple[str, str]] = (),
    stop: threading.Event | None = None,
    ready: Callable[[str], None] = print,
) -> None:
    """Run a camera at each address until `stop` is set.

    The first has the serial number `serial`, the others count up from it; without one, each serial number
    follows from the address (`registers.serial_at`). `power_on`: see `device.power_on_at_address`.
    `wires` connect the output Line2 of one address to the input Line1 of another.
    `ready` is called with a sentence that contains each camera's address.
    Raises SourceUnavailableError if an address is not available.
    """
    stop = stop or threading.Event()
    cameras: list[GigeCamera] = []
    try:
        for index, address in enumerate(addresses):
            values = dict(power_on or {})
            if first := serial or str(values.get(reg.DEVICE_SERIAL_NUMBER, "")):
                values[reg.DEVICE_SERIAL_NUMBER] = counted(first, index)
            camera = GigeCamera(
                address,
                power_on=values,
                scene=scene() if scene else None,
                faults=faults,
                deviations=deviations,
                bandwidth=bandwidth,
                segmentation=segmentation,
            )
            cameras.append(camera)
            ready(f"GigE Vision camera {camera.serial} is at {address}")
        by_address = dict(zip(addresses, cameras, strict=True))
        for sender, receiver in wires:
            by_address[sender].wire_to(by_address[receiver])
        stop.wait()
    finally:
        for camera in cameras:
            camera.close()


def counted(serial: str, index: int) -> str:
    """Return a serial number counted on: `SIM001`, 2 → `SIM003`."""
    stem = serial.rstrip("0123456789")
    digits = serial[len(stem) :]
    if not digits:
        return serial if index == 0 else f"{serial}-{index + 1}"
    return f"{stem}{int(digits) + index:0{len(digits)}d}"
