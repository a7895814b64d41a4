"""Both ends of a frame grabber's RPC: the service that carries out requests, and the link that makes them.

The service answers both dialects; the link finds out which one a server speaks, and whether it is ours.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable
from typing import Any

from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.core.errors import (
    FeatureAccessError,
    FeatureNotFoundError,
    FeatureValueError,
    FrameTimeoutError,
    GrabberError,
    TransportError,
    UsageError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_rate, frame_wait
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.net.numbered_features import BusType, CropType, NumberedFeatures
from grabbergui.net.tree import Terminal, TreeService, no_terminal
from grabbergui.net.yarp import grabber_values
from grabbergui.net.yarp.grabber_image import Capability
from grabbergui.net.yarp.grabber_rpc import (
    Call,
    CallReply,
    Operation,
    RefusedRequest,
    ReturnValue,
    encode_reply,
    read_request,
)
from grabbergui.net.yarp.grabber_values import Configuration, Value, Vertices, intrinsics
from grabbergui.net.yarp.os.bottle import Bottle, Buffer
from grabbergui.net.yarp.os.stranger_log import StrangerLog
from grabbergui.net.yarp.os.values import item_text

log = logging.getLogger(__name__)


FRAME_TIMEOUT = 1.0
"""Seconds, besides two frame periods, that an image request waits for the next frame."""

_STATUS: tuple[tuple[type[GrabberError], ReturnValue], ...] = (
    (FeatureNotFoundError, ReturnValue.NOT_IMPLEMENTED),
    (FeatureValueError, ReturnValue.OUT_OF_BOUNDS),
    (FeatureAccessError, ReturnValue.FAILED),
    (FrameTimeoutError, ReturnValue.NOT_READY),
    (TransportError, ReturnValue.COMMUNICATION),
)

_CROP_COUNT = "GetImageCrop failed: RECT mode requires 2 vertices."
_CROP_OUTSIDE = "GetImageCrop failed: utils::cropRect error."
_CROP_LIST = "List type not yet implemented"


class GrabberService:
    """Answers requests about one grabber. Any thread may call; each call may take as long as the camera."""

    def __init__(
        self,
        grabber: FrameGrabber,
        *,
        normalised: bool = False,
        terminal: Terminal = no_terminal,
        calibration: FittedCalibration | None = None,
    ) -> None:
        """Without `calibration` the visual parameters are those that the source itself reports."""
        self._grabber = grabber
        self._refusals = StrangerLog(grabber.info.title, level=logging.INFO)
        self._calibration = calibration or FittedCalibration(grabber)
        self._features = NumberedFeatures(grabber, normalised=normalised)
        self._tree = TreeService(grabber, terminal)
        self._queue: FrameQueue | None = None
        self._image_lock = threading.Lock()
        self._missed = -math.inf
        "Time (`time.monotonic`) at which the last wait for a frame was in vain."
        self._closed = False
        self._actions = self._make_actions()

    def close(self) -> None:
        """Release the grabber; requests that wait for a frame fail. May be called twice."""
        self._closed = True
        self._tree.close()
        if self._queue is not None:
            self._queue.close()

    def answer(self, request: Bottle) -> list[Buffer]:
        """Return the reply's message to a request of any vocabulary, in pieces."""
        if grabber_values.is_tree_request(request):
            return self._answer_tree(request).encode_parts()
        call = read_request(request)
        if isinstance(call, RefusedRequest):
            if call.reason:
                self._refusals.warn(f"request refused: {call.reason}")
            return [call.message]
        return encode_reply(call, self.perform(call))

    def perform(self, call: Call) -> CallReply:
        """Execute a call of YARP's interfaces; a failure is a reply as well."""
        try:
            return CallReply(self._actions[call.operation](*call.arguments))
        except GrabberError as error:
            self._refusals.warn(f"{call.operation.name}{call.arguments} failed: {error}")
            status = next((status for kind, status in _STATUS if isinstance(error, kind)), ReturnValue.FAILED)
            return CallReply(status=status, text=str(error) if isinstance(error, UsageError) else "")

    def _make_actions(self) -> dict[Operation, Callable[..., tuple[Value, ...]]]:
        numbered = self._features
        return {
            Operation.WIDTH: lambda: (self._size()[0],),
            Operation.HEIGHT: lambda: (self._size()[1],),
            Operation.IMAGE: lambda: self._image(Capability.COLOR),
            Operation.CROP: lambda kind, vertices: self._crop(Capability.COLOR, kind, vertices),
            Operation.RAW_WIDTH: lambda: (self._size()[0],),
            Operation.RAW_HEIGHT: lambda: (self._size()[1],),
            Operation.RAW_IMAGE: lambda: self._image(Capability.RAW),
            Operation.RAW_CROP: lambda kind, vertices: self._crop(Capability.RAW, kind, vertices),
            Operation.DESCRIPTION: self._description,
            Operation.HAS_FEATURE: lambda number: (numbered.has(number),),
            Operation.HAS_ON_OFF: lambda number: (numbered.has_on_off(number),),
            Operation.HAS_AUTO: lambda number: (numbered.has_auto(number),),
            Operation.HAS_MANUAL: lambda number: (numbered.has_manual(number),),
            Operation.HAS_ONE_PUSH: lambda number: (numbered.has_one_push(number),),
            Operation.GET_VALUE: lambda number: (numbered.value(number),),
            Operation.GET_VALUES: lambda number: numbered.values(number),
            Operation.GET_ACTIVE: lambda number: (numbered.active(number),),
            Operation.GET_MODE: lambda number: (int(numbered.mode(number)),),
            Operation.SET_VALUE: _done(numbered.set_value),
            Operation.SET_VALUES: _done(numbered.set_values),
            Operation.SET_ACTIVE: _done(numbered.set_active),
            Operation.SET_MODE: _done(numbered.set_mode),
            Operation.SET_ONE_PUSH: _done(numbered.one_push),
            Operation.RGB_WIDTH: lambda: (self._size()[0],),
            Operation.RGB_HEIGHT: lambda: (self._size()[1],),
            Operation.GET_RESOLUTION: self._size,
            Operation.SET_RESOLUTION: _done(self._set_size),
            Operation.CONFIGURATIONS: self._configurations,
            Operation.GET_FIELD_OF_VIEW: lambda: self._calibration.now().field_of_view,
            Operation.SET_FIELD_OF_VIEW: _no_zoom,
            Operation.INTRINSICS: lambda: (intrinsics(self._calibration.now(), time.time()),),
            Operation.GET_MIRROR: lambda: (bool(self._number(Role.MIRROR)),),
            Operation.SET_MIRROR: _done(
                lambda on: self._grabber.write_feature(self._name(Role.MIRROR), bool(on))
            ),
        }

    def _description(self) -> tuple[Value, ...]:
        info = self._grabber.info
        bus = BusType.USB if info.bus.upper().startswith("USB") else BusType.UNKNOWN
        return int(bus), ": ".join(part for part in (info.serial, info.model or info.title) if part)

    def _size(self) -> tuple[int, int]:
        return int(self._number(Role.WIDTH)), int(self._number(Role.HEIGHT))

    def _set_size(self, width: int, height: int) -> None:
        """Write both or neither."""
        before = self._size()[0]
        self._grabber.write_feature(self._name(Role.WIDTH), width)
        try:
            self._grabber.write_feature(self._name(Role.HEIGHT), height)
        except GrabberError:
            self._grabber.write_feature(self._name(Role.WIDTH), before)
            raise

    def _configurations(self) -> tuple[Value, ...]:
        width, height = self._size()
        return ((Configuration(width, height, frame_rate(self._grabber), "rgb"),),)

    def _name(self, role: Role) -> str:
        name = self._grabber.role(role)
        if name is None:
            what = role.name.lower()
            raise FeatureNotFoundError(f"{self._grabber.info.title} has no {what}", role.names[0])
        return name

    def _number(self, role: Role) -> float:
        value = self._grabber.feature(self._name(role)).value
        if not isinstance(value, (int, float)):
            raise FeatureAccessError(f"{role.names[0]} cannot be read at the moment", role.names[0])
        return value

    def _frame(self) -> Frame:
        """Return the next frame; a camera that does not stream has none.

        Several clients take turns at frames, but wait in vain together. Raises FrameTimeoutError.
        """
        asked = time.monotonic()
        with self._image_lock:
            if self._closed or asked <= self._missed:
                raise FrameTimeoutError("no frame arrived")
            if self._queue is None or self._queue.closed:
                self._queue = self._grabber.open_queue(1)
            try:
                return self._queue.get(frame_wait(self._grabber, FRAME_TIMEOUT))
            except FrameTimeoutError:
                self._missed = time.monotonic()
                raise

    def _image(self, capability: Capability) -> tuple[Value, ...]:
        return (capability.item(self._frame()),)

    def _crop(self, capability: Capability, kind: int, vertices: Vertices) -> tuple[Value, ...]:
        if kind == CropType.LIST:
            raise UsageError(_CROP_LIST)
        if kind != CropType.RECTANGLE or len(vertices) != 2:
            raise UsageError(_CROP_COUNT)
        frame = self._frame()
        (x1, y1), (x2, y2) = vertices
        left, right = sorted((x1, x2))
        top, bottom = sorted((y1, y2))
        if left < 0 or top < 0 or right >= frame.width or bottom >= frame.height:
            raise UsageError(_CROP_OUTSIDE)
        return (capability.item(frame, (left, top, right + 1, bottom + 1)),)

    def _answer_tree(self, request: Bottle) -> Bottle:
        try:
            verb, *arguments = [item_text(item) for item in request[1:]] or [""]
            return grabber_values.tree_success(self._tree.perform(verb, *arguments))
        except GrabberError as error:
            return grabber_values.tree_failure(error)


def _done(action: Callable[..., Any]) -> Callable[..., tuple[Value, ...]]:
    """Wrap an action without a result as a handler that returns no values."""

    def run(*arguments: Value) -> tuple[Value, ...]:
        action(*arguments)
        return ()

    return run


def _no_zoom(*_: Value) -> tuple[Value, ...]:
    raise FeatureNotFoundError("the field of view follows from the lens and the region; set those", "Zoom")
