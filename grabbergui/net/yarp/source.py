"""YARP ports as sources: `yarp:/grabber?carrier=mjpeg&nameserver=192.168.0.1:10000`."""

from __future__ import annotations

import logging
import time
from concurrent.futures import ThreadPoolExecutor

from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri, YarpOptions, read_options
from grabbergui.net.yarp.client import BUS, YarpGrabber
from grabbergui.net.yarp.client_link import GrabberLink
from grabbergui.net.yarp.os import carrier
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.names import check_port_name

log = logging.getLogger(__name__)

_RPC = "/rpc"
_AT_ONCE = 16
_MOST = 64
"""Ports asked in one discovery; a network with more frame grabbers than that is not ours to search."""


def create(uri: SourceUri) -> FrameGrabber:
    """Return the grabber for a port. Raises UsageError."""
    name = uri.name or "/grabber"
    options = read_options(YarpOptions, uri)
    try:
        check_port_name(name)
        if carrier.by_name(options.carrier).text:
            raise UsageError(f"'{uri}': images cannot travel over {options.carrier}")
    except UsageError:
        raise
    except GrabberError as error:
        raise UsageError(f"'{uri}': {error}") from error
    return YarpGrabber(
        name,
        nameserver=options.nameserver,
        carrier=options.carrier,
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
        info = DeviceInfo(f"yarp:{name}", bus=BUS, address=name)
        return link.info(info) if link.is_grabber() else None
    except GrabberError as error:
        log.debug("%s: %s", name, error)
        return None
    finally:
        link.close()
