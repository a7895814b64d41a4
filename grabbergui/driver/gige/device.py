"""A GigE Vision camera as a `Device`: control privilege, memory, description and stream; `gige:` sources.

The URI is `gige:` (the first found), `gige:192.168.0.10`, `gige:SERIAL`, `gige:MAC` or `gige:user name`; its
options are in `GigeUriOptions`.
"""

from __future__ import annotations

import ipaddress
import logging
import time
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from dataclasses import replace

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    GrabberError,
    OtherCameraError,
    ProtocolError,
    SourceNotFoundError,
    TransportError,
    UsageError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo, describe, distinct_names, require_same
from grabbergui.core.uri import GigeUriOptions, SourceUri, check_address, is_ip_address, read_options
from grabbergui.driver.description import fetch_description
from grabbergui.driver.device import DataLayout, Device, StreamRequest
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.genapi.cleaning import port_name
from grabbergui.driver.gige import bootstrap, discovery, privilege
from grabbergui.driver.gige.bootstrap import (
    GVCP_PORT,
    BootstrapRegister,
    ControlPrivilege,
    GvcpCapability,
    StreamChannel,
    ip_text,
)
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.gige.discovery import FoundDevice
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.heartbeat import Pulse
from grabbergui.driver.gige.identity import Identity, identity_of
from grabbergui.driver.gige.interfaces import Interface, interface_of, interfaces
from grabbergui.driver.gige.message_channel import MessageChannel
from grabbergui.driver.gige.quirks import DescriptionTraits, Quirk, known
from grabbergui.driver.gige.reasons import StreamFacts, no_frames, not_found
from grabbergui.driver.gige.stream.channel import (
    ALL_CHANNELS,
    GigeOptions,
    GigeStream,
    Streams,
    chosen_channels,
    tick_frequency,
)
from grabbergui.driver.gige.stream.packet_delay import PacketDelayPolicy
from grabbergui.driver.gige.stream.packet_size import PacketSizePolicy
from grabbergui.driver.gige.stream.packet_tests import arriving_sizes
from grabbergui.driver.gige.stream.resend import ResendPolicy

log = logging.getLogger(__name__)


ASK_CONTROLLERS = 0.4
"Seconds after which a search asks no further camera who controls it."
USUAL_HEARTBEAT_MS = 3000
"Timeout of a camera that does not report it."
MOST_CHANNELS = 512
"Stream channels of a device (GigE Vision, register 0x0904)."


class GigeDevice(Device):
    """One camera, named by IP address, serial number, MAC address or user name; empty: the first found.

    The name selects a camera only the first time; reopening finds the same unit or fails.
    """

    chunk_layout = DataLayout.GIGE_VISION
    event_layout = DataLayout.GIGE_VISION

    def __init__(self, name: str = "", options: GigeOptions | None = None) -> None:
        address = name if is_ip_address(name) else ""
        super().__init__(DeviceInfo(f"gige:{name}", bus="GigE Vision", address=address))
        self.name = name
        self.options = options or GigeOptions()
        self.identity: Identity | None = None
        "The camera's identity, once opened."
        self.interface: Interface | None = None
        "The host's network interface to the camera, once opened."
        self._link: ControlLink | None = None
        self._opening: ControlLink | None = None
        "The link of an `open` in progress, which `interrupt` closes."
        self._memory: DeviceMemory | None = None
        self._stream: Streams | None = None
        self._messages: MessageChannel | None = None
        self._tick_frequency = 0
        self._seen_as = ""
        "The address at which the camera sees this host; empty if it does not tell."
        self._little_endian = False
        "Whether the camera says that its memory is little-endian."
        self._numbers = False
        "Whether registers of four bytes are read and written as numbers, see `quirks`."

    def open(self, access: Access) -> Access:
        """Connect with control or read-only. Writes only the control privilege."""
        self.close()
        found = self._found()
        self._opening = link = self._link_to(found)
        memory = DeviceMemory(link)
        try:
            self._require_wanted()
            self._identify(link, memory, found)
            holder = None
            if access is Access.CONTROL:
                camera = f"{self.info.title} ({self.info.address})"
                privilege.take(link, camera, memory.capability, take_over=self.take_over)
                memory.writable = True
                privilege.offer(link, camera, memory.capability)
                holder = privilege.holder_of(link, memory.capability)
                self._seen_as = _host_seen_by(memory)
            timeout_ms = memory.read_optional(BootstrapRegister.HEARTBEAT_TIMEOUT_MS, USUAL_HEARTBEAT_MS)
            self.lost, link.on_lost = "", self.report_lost
            controlling = access is Access.CONTROL
            if not controlling:
                link.on_held = self.on_held
            link.start_heartbeat(Pulse.for_timeout(timeout_ms), controlling=controlling, holder=holder)
            indices = chosen_channels(memory, self.options.stream_channel)
            address, interface = self.info.address, self._require_interface()
        except BaseException:
            self._disconnect(link, memory)
            raise
        finally:
            self._opening = None
        self._link, self._memory = link, memory
        self._stream = Streams(
            [GigeStream(memory, address, interface, self.options, index) for index in indices]
        )
        return access

    def _found(self) -> FoundDevice | None:
        """Return the wanted camera's answer to a search; None for an address that the route leads to.

        An IP address is used literally, even if the camera was found at another address.
        """
        if is_ip_address(self.name):
            return discovery.find_at(self.name, self.options.search_timeout / 4)
        return self.search()

    def interrupt(self) -> None:
        """End the search and the commands of an `open` in progress. Any thread."""
        super().interrupt()
        if (link := self._opening) is not None:
            link.abandon()

    def _require_wanted(self) -> None:
        if self.interrupted:
            raise DeviceLostError(f"{self.info.title} was closed while it was opened")

    def close(self) -> None:
        """Close stream, events and connection, and release control. May be called twice."""
        link, memory = self._link, self._memory
        self.close_stream()
        messages, self._messages = self._messages, None
        if messages is not None:
            if link is not None and link.lost is None:
                messages.close()
            else:
                messages.abandon()
        self._link = self._memory = self._stream = None
        if link is not None and memory is not None:
            self._disconnect(link, memory)

    def _disconnect(self, link: ControlLink, memory: DeviceMemory) -> None:
        # Stop the heartbeat first, or it would report the control that we release as lost.
        link.stop_heartbeat()
        if memory.writable:
            privilege.release(link, self.info.uri)
        link.close()

    def search(self) -> FoundDevice:
        """Find the camera of this name; once opened, the same unit at whatever address it has now.

        Raises SourceNotFoundError; OtherCameraError if another camera answers, or more than one.
        """
        name, timeout = self.name, self.options.search_timeout
        if self.identity is None:
            found = discovery.find(name, timeout)
        else:
            found = discovery.find_again(self.info, name, timeout, lambda: self.interrupted)
        if found is not None:
            return found
        self._require_wanted()
        others = ", ".join(device.info().uri for device in discovery.discover(0.3)) or "none"
        silent = "no GigE Vision camera answers"
        if name:
            silent = f"{silent} to '{name}'"
        elif self.identity is not None:
            silent = f"{describe(self.info)} does not answer"
        asked = interfaces()
        raise SourceNotFoundError(
            f"{silent}; found: {others}; asked through {_named(asked)}. To do:"
            f" {not_found(asked)}; a camera in another network can be named by its IP address, as in"
            " gige:192.168.0.10"
        )

    def _link_to(self, found: FoundDevice | None) -> ControlLink:
        """Open the control link. Raises TransportError without a route."""
        try:
            return ControlLink(found.ip if found else self.name, interface=_interface_to(found))
        except TransportError as error:
            raise TransportError(f"{error}{self._note_of(found)}") from error

    def _note_of(self, found: FoundDevice | None) -> str:
        """Return a colon and the reason why a camera cannot be reached, from a search; empty if unknown."""
        if found is None and self.identity is None:
            with suppress(GrabberError):
                found = discovery.find(self.name, self.options.search_timeout)
        return f": {found.info().note}" if found and found.info().note else ""

    def _identify(self, link: ControlLink, memory: DeviceMemory, found: FoundDevice | None) -> None:
        ip = found.ip if found else self.name
        try:
            identity = found.identity if found else self._ask_identity(ip, memory)
            _require_readable(link)
            mac = _mac_of(memory)
            mode = memory.read_optional(BootstrapRegister.DEVICE_MODE, identity.device_mode)
            self._little_endian = not mode & bootstrap.BIG_ENDIAN_MODE
            memory.capability = GvcpCapability(memory.read_optional(BootstrapRegister.GVCP_CAPABILITY))
            self._tick_frequency = tick_frequency(memory)
        except AckTimeoutError as error:
            if error.postponed:
                raise TransportError(f"what answers at {ip} is not ready: {error}") from error
            asked = [each for each in interfaces() if each.reaches(ip)]
            note = self._note_of(found) or f"; {not_found(asked)}"
            raise SourceNotFoundError(
                f"no GigE Vision camera answers at {ip}, asked through"
                f" {_named(asked or [interface_of(link.local_address)])}{note}"
            ) from error
        except DeviceStatusError as error:
            if error.status != Status.ACCESS_DENIED:
                raise
            # An application with exclusive control also prevents others from reading.
            raise AccessDeniedError(
                f"another application has exclusive control of the camera at {ip}; close it there"
            ) from error
        except ProtocolError as error:
            raise TransportError(f"what answers at {ip} is no GigE Vision camera: {error}") from error
        interface = _interface_to(found) or interface_of(link.local_address)
        info = (found or FoundDevice(identity, ip, interface)).info()
        if mac and info.hardware_id and mac != int(info.hardware_id.replace(":", ""), 16):
            raise OtherCameraError(
                f"{ip} is the address of two cameras: {describe(info)} is wanted, but the one of MAC address"
                f" {mac.to_bytes(8, 'big')[2:].hex(':')} answers; give one of them another address"
                " (grabbergui force-ip)"
            )
        if self.identity is not None:
            require_same(self.info, info)
        self.identity, self.interface = identity, interface
        _, mark, query = self.info.uri.partition("?")
        uri = self.info.uri if self.name else info.uri + mark + query
        self.info = replace(info, uri=uri, address=ip, note="")

    def _ask_identity(self, ip: str, memory: DeviceMemory) -> Identity:
        """Return the identity from DISCOVERY, or from registers if a router drops DISCOVERY."""
        found = discovery.ask(ip, self.options.search_timeout / 4)
        return found.identity if found else identity_of(memory.read)

    def read(self, address: int, length: int) -> bytes:
        """Read memory of any length and alignment. Raises as `DeviceMemory.read`."""
        memory = self._opened()
        return memory.read_numbers(address, length) if self._numbers else memory.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Write memory of any length and alignment. Raises as `DeviceMemory.write`."""
        memory = self._opened()
        if self._numbers:
            memory.write_numbers(address, data)
        else:
            memory.write(address, data)

    @property
    def word_order(self) -> tuple[bool, bool]:
        """Whether the camera says that its memory is little-endian; whether words are read as numbers."""
        return self._little_endian, self._numbers

    def read_number(self, register: int) -> int:
        """Read a 32-bit register of the standard. Raises as `DeviceMemory.read`."""
        return self._opened().read_register(register)

    def write_number(self, register: int, value: int) -> None:
        """Write a 32-bit register of the standard. Raises as `DeviceMemory.write`."""
        self._opened().write_numbers(register, value.to_bytes(4, "big"))

    def use_description(self, xml: str) -> None:
        """Choose how registers are accessed; before that, the memory counts as big-endian."""
        memory, little_endian = self._opened(), self._little_endian
        traits = DescriptionTraits.of(xml, port_name(xml))
        self._numbers = traits.numbers(little_endian=little_endian)
        memory.little_endian = little_endian and not traits.contradict(little_endian=little_endian)
        if self.options.registers != "auto":
            self._numbers = self.options.registers == "numbers"
        elif little_endian and not memory.little_endian:
            log.info(
                "%s: DeviceMode says little-endian, the description big-endian; registers of four bytes"
                " are accessed as numbers (READREG, WRITEREG)",
                self.info.title,
            )

    def description(self) -> bytes:
        """Fetch the GenICam XML from the URL registers. Raises TransportError."""
        memory = self._opened()
        fields = (bootstrap.FIRST_URL, bootstrap.SECOND_URL)
        return fetch_description((_text_or_none(memory, field) for field in fields), memory.read)

    def bootstrap_registers(self) -> list[tuple[str, int, int]]:
        """Return GigE Vision's registers, of the stream channels those that the camera announces."""
        channels = (
            self._opened().read_optional(BootstrapRegister.STREAM_CHANNELS, 1)
            & bootstrap.STREAM_CHANNELS_MASK
        )
        return bootstrap.known_registers(min(channels, MOST_CHANNELS))

    def open_events(self) -> None:
        """Open the message channel, if the camera has one."""
        memory = self._opened()
        if self._messages is not None or not memory.read_optional(BootstrapRegister.MESSAGE_CHANNELS):
            return
        interface = self._require_interface()
        self._messages = MessageChannel(memory, self.info.address, interface, self.report_event)

    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        """Open the chosen stream channels; `deliver` is called on their threads, one call at a time."""
        self._opened()
        assert self._stream is not None
        if known(Quirk.BIG_ENDIAN_PIXELS, self.info.vendor, self.info.model):
            request = replace(request, big_endian_pixels=True)
        if self.options.payload_size:
            request = replace(request, payload_size=self.options.payload_size)
        self._stream.open(request, deliver, self._tick_frequency)
        self._receiving = self._stream

    def silence(self) -> str:
        """Return why no frames arrive; see `reasons`."""
        stream, interface = self._stream, self.interface
        if stream is None or interface is None:
            return ""
        first = stream.channels[0]
        facts = StreamFacts(
            stream.statistics(),
            self.info.address,
            first.port,
            interface,
            next((channel.refusal for channel in stream.channels if channel.refusal), ""),
            self._seen_as,
            first.packet_size,
        )
        return no_frames(facts, interfaces() if not facts.statistics.packets else ())

    def test_packets(self) -> list[tuple[int, bool]]:
        """Test packet sizes; see `arriving_sizes`. Needs control, and no stream."""
        memory = self._opened()
        (index, *_) = chosen_channels(memory, self.options.stream_channel)
        return arriving_sizes(memory, self._require_interface(), self.info.address, StreamChannel(index))

    def _opened(self) -> DeviceMemory:
        memory = self._memory
        if memory is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return memory

    def _require_interface(self) -> Interface:
        assert self.interface is not None
        return self.interface


def _named(asked: Sequence[Interface]) -> str:
    """Return the interfaces on which a camera did not answer, for a message."""
    return ", ".join(f"{each.name or 'the address'} ({each.ip})" for each in asked) or "no interface"


def _interface_to(found: FoundDevice | None) -> Interface | None:
    """Return the interface on which a camera answered; None where the routing table has to choose."""
    if found is None or not found.reachable or found.interface.loopback or not found.interface.name:
        return None
    return found.interface


def _require_readable(link: ControlLink) -> None:
    """Raise the refusal of a camera that another application has exclusive control of.

    Every camera lets others read CCP otherwise, and some lets them read CCP alone.
    """
    if link.read_register(BootstrapRegister.CCP) & ControlPrivilege.EXCLUSIVE:
        link.read_register(BootstrapRegister.GVCP_CAPABILITY)


def _host_seen_by(memory: DeviceMemory) -> str:
    """Return the address of the controller, ourselves, as the camera sees it; empty if it does not tell."""
    if GvcpCapability.PRIMARY_APPLICATION not in memory.capability:
        return ""
    number = memory.read_optional(BootstrapRegister.PRIMARY_APPLICATION_IP)
    return ip_text(number) if number else ""


def _mac_of(memory: DeviceMemory) -> int:
    """Return the MAC address as a number; 0 if the camera does not tell."""
    high, low = (
        memory.read_optional(BootstrapRegister.MAC_HIGH, -1),
        memory.read_optional(BootstrapRegister.MAC_LOW, -1),
    )
    return (high & 0xFFFF) << 32 | low if min(high, low) >= 0 else 0


def _text_or_none(memory: DeviceMemory, field: bootstrap.Field) -> str:
    try:
        return memory.read_text(field)
    except DeviceStatusError as error:
        log.info("the camera has no text at 0x%04X: %s", field.address, error)
        return ""


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera of a URI, without opening or searching for it. Raises UsageError."""
    chosen = read_options(GigeUriOptions, uri)
    check_address(uri, GVCP_PORT)
    options = GigeOptions(
        packet_size=PacketSizePolicy.parse(chosen.packet_size),
        resend=ResendPolicy(enabled=chosen.resend),
        packet_delay=PacketDelayPolicy.parse(chosen.packet_delay, chosen.bandwidth),
        stream_channel=_channel(uri, chosen.stream_channel),
        multicast=_checked_group(uri, chosen.multicast),
        pixels=chosen.pixels,
        payload_size=chosen.payload_size,
        registers=chosen.registers,
        batched=not chosen.plain,
    )
    device = GigeDevice(uri.name, options)
    device.description_file = chosen.description
    device.info = replace(device.info, uri=str(uri))
    return DeviceGrabber(device, deliver_incomplete=chosen.incomplete)


def _channel(uri: SourceUri, text: str) -> int:
    if text == "all":
        return ALL_CHANNELS
    if text.isdecimal() and int(text) < MOST_CHANNELS:
        return int(text)
    raise UsageError(f"{uri}: stream_channel={text}: write a number from 0 to {MOST_CHANNELS - 1}, or all")


def _checked_group(uri: SourceUri, group: str) -> str:
    try:
        if group and not ipaddress.IPv4Address(group).is_multicast:
            raise ValueError(group)
    except ValueError as error:
        raise UsageError(f"{uri}: multicast={group}: write a group's address, e.g. 239.192.0.1") from error
    return group


def discover(timeout: float) -> list[DeviceInfo]:
    """Return every camera that answers within `timeout` seconds, each with a unique URI.

    The note of one that another program controls names that program. Asking for it takes `ASK_CONTROLLERS`
    seconds more at most.
    """
    found = discovery.discover(timeout)
    names = distinct_names(device.names for device in found)
    infos = [device.info(name) for device, name in zip(found, names, strict=True)]
    end = time.monotonic() + ASK_CONTROLLERS
    for index, device in enumerate(found):
        if device.reachable and time.monotonic() < end and (user := _user_of(device)):
            infos[index] = replace(infos[index], note=f"in use by {user}")
    return infos


def _user_of(device: FoundDevice) -> str:
    try:
        with closing(ControlLink(device.ip, timing=privilege.BRIEF, interface=_interface_to(device))) as link:
            return privilege.user_of(link)
    except GrabberError as error:
        log.debug("%s does not say who controls it: %s", device.ip, error)
        return ""
