"""Finds cameras by DISCOVERY: by broadcast on the host's IPv4 interfaces, by unicast to given addresses."""

from __future__ import annotations

import ipaddress
import logging
import selectors
import socket
import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from urllib.parse import quote

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.identity import DeviceInfo, require_one, require_same, unit
from grabbergui.driver.gige.bootstrap import GVCP_PORT
from grabbergui.driver.gige.gvcp import Ack, CommandCode
from grabbergui.driver.gige.identity import DISCOVERY_REQ_ID, NO_MAC, Identity, encode_discovery
from grabbergui.driver.gige.interfaces import Interface, interfaces, leave_through

log = logging.getLogger(__name__)

LIMITED_BROADCAST = "255.255.255.255"
NAMESAKES_S = 0.05
"""Seconds to wait for a second camera that answers to the same name."""
OVERTIME_S = 0.1
"""Longest time after the end of a round for which answers are taken that have arrived."""
CANCEL_PERIOD = 0.05
"""Seconds between checks whether a search was cancelled."""
MAX_DEVICES = 1024
"Answers beyond it are ignored: a flood must not exhaust memory."
MOST_AT_ONE_ADDRESS = 16
"Devices that answer from one address, at most: a flood from there must leave room for the others."


@dataclass(frozen=True)
class FoundDevice:
    """A device that answered."""

    identity: Identity
    ip: str
    "The address it reports, or its answer's source address if it reports none."
    interface: Interface
    "The host's interface that received its answer."

    @property
    def key(self) -> tuple[str, ...]:
        """Key of the device, the same on each interface that received its answer."""
        mac = self.identity.mac
        return (mac, self.ip) if mac != NO_MAC else (self.identity.serial, self.ip)

    @property
    def reachable(self) -> bool:
        """Whether its address is in the subnet of `interface`, or on this machine."""
        here = self.interface.loopback or ipaddress.IPv4Address(self.ip).is_loopback
        return here or self.interface.reaches(self.ip)

    @property
    def names(self) -> tuple[str, ...]:
        """Serial number or else MAC address, IP address, MAC address and user name; some may be empty."""
        identity = self.identity
        mac = identity.mac if identity.mac != NO_MAC else ""
        return (identity.serial or mac, self.ip, mac, identity.user_name)

    def answers_to(self, name: str) -> bool:
        """Whether `name` is one of its names; a MAC address also without colons or with hyphens."""
        wanted = name.strip().lower()
        mac = self.identity.mac
        return wanted in (known.lower() for known in self.names if known) or (
            mac != NO_MAC and wanted.replace(":", "").replace("-", "") == mac.replace(":", "")
        )

    def info(self, name: str = "") -> DeviceInfo:
        """Return the entry for the list of sources; its URI has `name` (by default the first of `names`)."""
        identity = self.identity
        mac = identity.mac if identity.mac != NO_MAC else ""
        note = ""
        if not self.reachable:
            interface = self.interface
            note = (
                f"its address {self.ip} is in another subnet than {interface.name} ({interface.ip}/"
                f"{interface.netmask}); give it one there (force IP) or change the host's"
            )
        return DeviceInfo(
            uri=f"gige:{quote(name or identity.serial or mac or self.ip, safe=':')}",
            vendor=identity.vendor,
            model=identity.model,
            serial=identity.serial,
            bus="GigE Vision",
            address=self.ip,
            hardware_id=mac,
            user_name=identity.user_name,
            version=identity.version,
            interface=self.interface.name,
            note=note,
        )


def discover(
    timeout: float = 1.0, addresses: Iterable[str] = (), *, broadcast: bool = True
) -> list[FoundDevice]:
    """Return every device that answers within `timeout` seconds, each once, sorted by address.

    `addresses` also get a unicast DISCOVERY (devices behind a router, or at another loopback address).
    """
    return Search(addresses, broadcast=broadcast).run(timeout)


def find(name: str, timeout: float = 1.0) -> FoundDevice | None:
    """Return the device with a name (see `FoundDevice.answers_to`; empty: the first that answers).

    Raises OtherCameraError if several devices answer to the name.
    """

    def answers(device: FoundDevice) -> bool:
        return not name or device.answers_to(name)

    linger = NAMESAKES_S if name else 0.0
    found = Search().run(timeout, lambda device: device.reachable and answers(device), linger)
    candidates = [device for device in found if answers(device)]
    if name:
        require_one(name, [device.info(device.ip) for device in candidates])
    return min(candidates, key=lambda device: not device.reachable, default=None)


def find_again(
    wanted: DeviceInfo, name: str, timeout: float, cancelled: Callable[[], bool]
) -> FoundDevice | None:
    """Return the same unit as `wanted`, at whatever address it has now; None soon after `cancelled` holds.

    Raises OtherCameraError if another device answers to `name` instead.
    """

    def is_wanted(device: FoundDevice) -> bool:
        return unit(device.info()) == unit(wanted)

    search = Search(cancelled=cancelled)
    found = search.run(timeout, lambda device: device.reachable and is_wanted(device))
    again = min(filter(is_wanted, found), key=lambda device: not device.reachable, default=None)
    if again is None and name:
        for device in found:
            if device.answers_to(name):
                require_same(wanted, device.info())
    return again


def ask(ip: str, timeout: float) -> FoundDevice | None:
    """Return the device at an address as soon as it answers; None if it does not."""
    found = Search([ip], broadcast=False).run(timeout, until=lambda device: True)
    return found[0] if found else None


def find_at(ip: str, timeout: float) -> FoundDevice | None:
    """Return the device at an address, with the interface that it answers on, if several are in its network.

    None if it does not answer, or one interface alone is in its network: then the routing table is right.
    """
    candidates = [each for each in interfaces() if not each.loopback and each.reaches(ip)]
    if len({each.name for each in candidates}) < 2:
        return None
    found = Search([ip]).run(timeout, lambda device: device.ip == ip)
    return next((device for device in found if device.ip == ip), None)


class Search:
    """A search, used once."""

    def __init__(
        self,
        addresses: Iterable[str] = (),
        *,
        broadcast: bool = True,
        cancelled: Callable[[], bool] | None = None,
    ) -> None:
        """The search ends soon after `cancelled` holds."""
        self._addresses = list(addresses)
        self._cancelled = cancelled
        self._broadcast = broadcast
        self._found: dict[tuple[str, ...], FoundDevice] = {}
        self._at_address: Counter[str] = Counter()
        "Devices found, by the address that their answer came from."

    def run(
        self, timeout: float, until: Callable[[FoundDevice], bool] | None = None, linger: float = 0.0
    ) -> list[FoundDevice]:
        """Send DISCOVERY, repeat it half-way in case a datagram was lost, and collect the answers.

        The second round includes interfaces that came up after the first, e.g. by plugging in a cable. The
        search ends `linger` seconds after the first device for which `until` holds.
        """
        with selectors.DefaultSelector() as selector:
            try:
                for _ in range(2):
                    self._ask(self._open(selector))
                    if self._collect(selector, timeout / 2, until, linger):
                        break
            finally:
                for key in list(selector.get_map().values()):
                    key.fileobj.close()  # type: ignore[union-attr]
        return sorted(self._found.values(), key=lambda device: socket.inet_aton(device.ip))

    def _collect(
        self,
        selector: selectors.BaseSelector,
        seconds: float,
        until: Callable[[FoundDevice], bool] | None,
        linger: float,
    ) -> bool:
        """Take answers for `seconds`; return whether `until` held for one, `linger` seconds before.

        At the end, take what has arrived: this program may have been held up for longer than that.
        """
        end = time.monotonic() + seconds
        holds = False
        while True:
            left = end - time.monotonic()
            if self._cancelled is None:
                ready = selector.select(max(0.0, left))
            elif self._cancelled():
                return True
            else:
                ready = selector.select(min(max(0.0, left), CANCEL_PERIOD))
            for key, _ in ready:
                device = self._take(key.fileobj, key.data, until)  # type: ignore[arg-type]
                if device is not None and until is not None and not holds and until(device):
                    holds, end = True, min(end, time.monotonic() + linger)
            if left <= 0 and (not ready or left < -OVERTIME_S):
                return holds

    def _open(self, selector: selectors.BaseSelector) -> list[tuple[socket.socket, Interface]]:
        """Open sockets on interfaces that have none yet; return all sockets."""
        opened = [(key.fileobj, key.data) for key in selector.get_map().values()]
        known = {interface.ip for _, interface in opened}
        for interface in interfaces() if self._broadcast else [Interface("", "0.0.0.0")]:
            if interface.ip in known:
                continue
            asker = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                asker.setblocking(False)
                asker.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
                # Bound to its address, a limited broadcast leaves through this interface.
                asker.bind((interface.ip, 0))
                leave_through(asker, interface)
            except OSError as error:
                log.debug("cannot search on %s: %s", interface.name, error)
                asker.close()
                continue
            selector.register(asker, selectors.EVENT_READ, interface)
            opened.append((asker, interface))
        return opened  # type: ignore[return-value]

    def _ask(self, sockets: list[tuple[socket.socket, Interface]]) -> None:
        for asker, interface in sockets:
            targets = self._targets(interface)
            for ip, datagram in targets:
                try:
                    asker.sendto(datagram, (ip, GVCP_PORT))
                except OSError as error:
                    log.debug("cannot search on %s at %s: %s", interface.name, ip, error)

    def _targets(self, interface: Interface) -> list[tuple[str, bytes]]:
        plain = encode_discovery()
        given = [(ip, plain) for ip in self._addresses if interface.loopback == ip.startswith("127.")]
        if not self._broadcast:
            return [(ip, plain) for ip in self._addresses]
        if interface.loopback:
            return [("127.0.0.1", plain), (interface.broadcast, plain), *given]
        return [
            (LIMITED_BROADCAST, encode_discovery(allow_broadcast_ack=True)),
            (interface.broadcast, plain),
            *given,
        ]

    def _take(
        self,
        asker: socket.socket,
        interface: Interface,
        until: Callable[[FoundDevice], bool] | None = None,
    ) -> FoundDevice | None:
        """Read an answer; keep its device if there is room, and always if `until` holds for it."""
        try:
            datagram, (source, _) = asker.recvfrom(2048)
            ack = Ack.decode(datagram)
            if ack.failed or ack.acknowledge != CommandCode.DISCOVERY + 1 or ack.ack_id != DISCOVERY_REQ_ID:
                return None
            identity = Identity.decode(ack.payload)
        except (OSError, RemoteProtocolError) as error:
            log.debug("an answer to discovery on %s: %s", interface.name, error)
            return None
        ip = source if identity.ip == "0.0.0.0" or interface.loopback else identity.ip
        device = FoundDevice(identity, ip, interface)
        known = self._found.get(device.key)
        # A device may answer on several interfaces; prefer the one in whose subnet its address is.
        if known is None:
            room = len(self._found) < MAX_DEVICES and self._at_address[source] < MOST_AT_ONE_ADDRESS
            if room or (until is not None and len(self._found) < 2 * MAX_DEVICES and until(device)):
                self._found[device.key] = device
                self._at_address[source] += 1
        elif not known.reachable:
            self._found[device.key] = device
        return device
