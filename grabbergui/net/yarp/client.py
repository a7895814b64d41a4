"""A frame grabber on a YARP network as a source: `yarp:/grabber`, with options as in `YarpOptions`."""

from __future__ import annotations

import logging
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from typing_extensions import override

from grabbergui.core.errors import (
    DeviceLostError,
    GrabberError,
    OtherCameraError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
    UsageError,
)
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.settings import SettingKey, WriteResult
from grabbergui.core.uri import SourceUri, YarpOptions, read_options
from grabbergui.net.remote_grabber import RemoteGrabber
from grabbergui.net.tree import TreeFeatures
from grabbergui.net.yarp.client_stream import ComponentReaders, ImageStream
from grabbergui.net.yarp.grabber_image import MONO, PIXELS
from grabbergui.net.yarp.grabber_link import Features, GrabberLink
from grabbergui.net.yarp.os import carrier as wire
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import InputPort
from grabbergui.net.yarp.os.target import check_port_name

log = logging.getLogger(__name__)

WATCH_PERIOD = 0.1
"""Period in seconds of checks for changes by others and for the server's presence; one request to a server of
ours."""

SLOW_WATCH_PERIOD = 0.4
"""Period for a server of YARP's own, which must be asked for every value."""

CLOSE_SECONDS = 0.3
"""Seconds that `close` waits for the server and the name server."""

LOOKS_PER_SEARCH = 10
"""Checks per search for the camera's component ports. A search fetches the name server's list."""

BUS = "YARP"

_GONE = (TransportError, SourceNotFoundError, SourceUnavailableError)
_RPC = "/rpc"
_IMAGE_CARRIERS = [carrier.name for carrier in wire.CARRIERS.values() if not carrier.text]
_AT_ONCE = 16
_MOST = 64
"""Ports that one discovery examines."""


class YarpGrabber(RemoteGrabber[ImageStream]):
    """A remote camera: one of ours with every feature it has, any other with YARP's numbered features.

    Images need a port of our own, registered with the same name server while streaming. A watcher thread
    reports changes by others (while there are listeners), detects the loss of the server, and reconnects when
    it is back.
    """

    def __init__(
        self,
        name: str,
        *,
        nameserver: str = "",
        carrier: str = "fast_tcp",
        bind: str = "",
        components: bool = True,
        uri: str = "",
    ) -> None:
        """Make a grabber for the port `name`; `nameserver` is HOST:PORT, by default the configured one.

        With `components`, frames also contain what a server of ours sends on NAME/range, NAME/confidence ….
        """
        super().__init__(DeviceInfo(uri or _uri(name), bus=BUS, address=name, user_name=name))
        self._name = name
        self._nameserver = nameserver
        self._carrier = carrier
        self._bind = bind
        self._with_components = components
        self._names: NameClient | None = None
        self._link: GrabberLink | None = None
        self._features: Features | None = None
        self._stopping = threading.Event()
        self._watcher: threading.Thread | None = None
        self._ending: threading.Thread | None = None
        "Ends what the last `close` left to it."
        self._looks = 0
        "Checks since the stream was started."
        self._starts_on_return = False
        "Whether to start the stream once the server is back."

    @override
    def open(self, access: Access = Access.CONTROL) -> None:
        """Raises SourceUnavailableError without a name server."""
        if self._ending is not None:
            self._ending.join()
        with self._lock:
            if self._link is not None:
                return
            self._names = NameClient.find(self._nameserver)
            self._link, self._features = self._connect(self._names)
            self._access, self._lost = access, ""
            self._stopping.clear()
            self._watcher = threading.Thread(target=self._watch, name=f"yarp watch {self._name}", daemon=True)
            self._watcher.start()
        self.connection_changed.emit(ConnectionState.OPEN, "")

    @override
    def close(self) -> None:
        """Release the server; one that hangs is left to a thread in the background after CLOSE_SECONDS."""
        self._stopping.set()
        link, was_open = self._link, self._features is not None
        if link is not None:
            link.close()  # ends a request that waits for its answer
        ending = threading.Thread(target=self._end, args=(threading.current_thread(),), daemon=True)
        ending.name = f"yarp end of {self._name}"
        try:
            ending.start()
        except RuntimeError:  # the program ends, or has no threads left
            self._end(threading.current_thread())
        else:
            self._ending = ending
            ending.join(CLOSE_SECONDS)
        self._fanout.close()
        if was_open:
            self.connection_changed.emit(ConnectionState.CLOSED, "")

    def _end(self, closing: threading.Thread) -> None:
        """Wait for the watcher, unless it is the thread that closes; then release everything."""
        watcher, self._watcher = self._watcher, None
        if watcher is not None and watcher is not closing:
            watcher.join()
        with self._lock:
            self.stop()
            self._disconnect()
            self._features = None

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        feature = super().write_feature(name, value)
        self.features_changed.emit(frozenset({name}))
        return feature

    @override
    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        result = super().write_setting(key, value)
        changes = (*result.written, *result.consequences)
        self.features_changed.emit(frozenset(change.key.name for change in changes))
        return result

    def _known(self) -> Features:
        features = self._features
        if features is None:
            raise TransportError(f"{self._name} is not open")
        return features

    def _connected(self) -> Features:
        if self._link is None or self._link.failed:
            raise DeviceLostError(f"{self._name} is not available; it is reconnected when it returns")
        return self._known()

    @override
    def start(self, *, keep_trigger: bool = False) -> None:
        """Receive frames, once the server is back if it is away. It decides whether the camera runs."""
        with self._lock:
            if self._stream is not None:
                return
            self._starts_on_return |= self._link is None
            self._connected()
            assert self._names and self._link
            components, carrier = None, self._carrier
            if self._link.ours and not wire.by_name(carrier).pull:
                carrier = f"{carrier}+{PIXELS}.{MONO}"
            if self._with_components and self._link.ours:
                components = ComponentReaders(
                    self,
                    self._name,
                    self._names,
                    self._fanout.put,
                    carrier=self._carrier.partition("+")[0],  # the plug-in of colours is not for distances
                    bind=self._bind,
                )
            stream = ImageStream(
                self._name,
                self._names,
                self._fanout.put,
                carrier=carrier,
                bind=self._bind,
                components=components,
            )
            self._fanout.clear()
            stream.open()
            self._stream = stream
            self._starts_on_return = False
            self._looks = 0

    @override
    def stop(self) -> None:
        self._starts_on_return = False
        super().stop()

    def _connect(self, names: NameClient) -> tuple[GrabberLink, Features]:
        contact = names.query(self._name)
        if contact.address == names.server.address or self._name == names.server.name:
            raise TransportError(
                f"{self._name} is the name server, not a camera; `grabbergui list` shows the cameras"
            )
        link = GrabberLink(self._name, names)
        try:
            self._recognise(link.info(replace(self.info, interface=contact.host)))
            return link, link.features()
        except BaseException:
            link.close()
            raise

    def _disconnect(self) -> None:
        if self._link is not None:
            self._link.close()
            self._link = None

    def _watch(self) -> None:
        complaint = ""
        while not self._stopping.wait(self._watch_period()):
            try:
                if self._link is None:
                    self._return()
                else:
                    self._look()
                complaint = ""
            except OtherCameraError as error:
                self._lose(str(error))
            except _GONE as error:
                if not self._stopping.is_set():  # otherwise `close` ended the request
                    self._lose_server(str(error))
            except GrabberError as error:
                if str(error) != complaint:  # ten times a second otherwise
                    complaint = str(error)
                    log.warning("%s: %s", self._name, complaint)

    def _watch_period(self) -> float:
        link = self._link
        return WATCH_PERIOD if link is not None and link.ours else SLOW_WATCH_PERIOD

    def _look(self) -> None:
        """Check the server and the stream once. Raises if either is lost."""
        with self._lock:
            link, features = self._link, self._features
            if link is None or features is None:
                return
            if link.failed:
                raise TransportError(link.failed)
            changed: frozenset[str] = frozenset()
            late = not any(features.tree.descriptions()) and not link.silent
            if late:
                self._features = features = link.features()
                changed = frozenset(description.name for description in features.tree.descriptions())
            elif len(self.features_changed):
                changed = features.changes()
            elif isinstance(features, TreeFeatures):
                features.look()
            else:
                link.check()
            self._forget_seen(changed)
        self._look_at_stream()
        if changed and late:  # a server may answer before it has its camera
            self.connection_changed.emit(ConnectionState.OPEN, f"{self._name} has its camera")
        self._report_camera(features)
        if changed:
            self.features_changed.emit(changed)

    def _look_at_stream(self) -> None:
        """Connect the stream if it is not connected. Without the lock, as others may take long to answer."""
        stream = self._stream
        if stream is None:
            return
        try:
            if not stream.connected:
                stream.connect()
        except _GONE:
            if stream is self._stream:
                raise
            return  # it was stopped in the meantime
        if self._looks % LOOKS_PER_SEARCH == 0:
            try:
                stream.look()
            except _GONE as error:  # open connections do not need the name server
                log.info("%s: its components are not searched for: %s", self._name, error)
        self._looks += 1

    def _return(self) -> None:
        """Try to connect again. Raises while the server is still away."""
        assert self._names
        # Without the lock: a server that hangs takes long.
        link, features = self._connect(self._names)
        with self._lock:
            if self._stopping.is_set():
                link.close()
                return
            self._link, self._features = link, features
            try:
                if not (camera_lost := self._ask_for_loss()):
                    self._compare_with_seen()
                if self._stream is not None:
                    self._stream.reconnect()  # even if it seems connected
                elif self._starts_on_return:
                    self.start()
            except BaseException:
                self._disconnect()  # so that the next attempt reports the return
                raise
        if camera_lost:
            self._lose(camera_lost)
        else:
            self._report_return()
        self.features_changed.emit(frozenset(d.name for d in self.feature_tree().descriptions()))

    def _lose_server(self, reason: str) -> None:
        with self._lock:
            present = self._link is not None
            self._disconnect()
        if present:
            self._lose(reason)


def create(uri: SourceUri) -> FrameGrabber:
    """Return the grabber for a port. Raises UsageError."""
    name = uri.name.rstrip("/") or uri.name or "/grabber"  # its requests are not at /grabber//rpc
    options = read_options(YarpOptions, uri)
    check_port_name(name)
    carrier = options.carrier.replace(" ", "+")  # as a query spells it
    base = carrier.partition("+")[0]
    if base not in _IMAGE_CARRIERS:
        raise UsageError(f"'{uri}': images arrive over {', '.join(_IMAGE_CARRIERS)}, not over '{base}'")
    plug_in = wire.modifiers_of(carrier).get("recv")
    if plug_in and (plug_in not in InputPort.plug_ins or wire.by_name(carrier).pull):
        raise UsageError(f"'{uri}': this end has no such plug-in; choose a carrier without +recv.{plug_in}")
    return YarpGrabber(
        name,
        nameserver=options.nameserver,
        carrier=carrier,
        bind=options.bind,
        components=options.components,
        uri=str(uri),
    )


def discover(timeout: float) -> list[DeviceInfo]:
    """Return the frame grabbers that the configured name server knows; none if there is no name server."""
    deadline = time.monotonic() + timeout
    try:
        names = NameClient.find()
        known = {contact.name for contact in names.list() if contact.carrier == "tcp"}
    except GrabberError as error:
        log.debug("looking for YARP ports: %s", error)
        return []
    candidates = sorted(name for name in known if name + _RPC in known)[:_MOST]
    if not candidates:
        return []
    with ThreadPoolExecutor(min(_AT_ONCE, len(candidates))) as pool:
        found = pool.map(lambda name: _examine(name, names, deadline), candidates)
        return [info for info in found if info is not None]


def _uri(name: str) -> str:
    """Return the URI that opens a port; a name such as `/camera?left` needs escapes."""
    return str(SourceUri("yarp", name))


def _examine(name: str, names: NameClient, deadline: float) -> DeviceInfo | None:
    left = deadline - time.monotonic()
    if left <= 0:
        return None
    try:
        link = GrabberLink(name, names, timeout=left)
    except GrabberError as error:
        log.debug("%s: %s", name, error)
        return None
    try:
        info = DeviceInfo(_uri(name), bus=BUS, address=name)
        return link.info(info) if link.is_grabber() else None
    except GrabberError as error:
        log.debug("%s: %s", name, error)
        return None
    finally:
        link.close()
