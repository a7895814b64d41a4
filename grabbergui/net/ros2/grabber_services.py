"""The services of a served grabber: single features, settings, the whole tree."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import FeatureValueError, GrabberError, UsageError
from grabbergui.core.features import Feature, FeatureKind, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.numbered_features import (
    FeatureId,
    FeatureMode,
    FeatureModes,
    NumberedFeatures,
    entry_at,
    number_of,
)
from grabbergui.net.ros2.callers import create_service
from grabbergui.net.ros2.requirements import require_interfaces
from grabbergui.net.ros2.runtime import sendable
from grabbergui.net.tree import Terminal, TreeService, dumps, no_terminal


class GrabberServices:
    """Offers the services of `grabber_interfaces` below the node's name. Failures are replies.

    Features go by YARP's numbers or GenICam names; `ask` has the whole tree. Callbacks run on the node's
    thread.
    """

    def __init__(self, node: Any, grabber: FrameGrabber, terminal: Terminal = no_terminal) -> None:
        require_interfaces()
        from grabber_interfaces import srv

        self._grabber = grabber
        self._numbers = NumberedFeatures(grabber)
        self._modes = FeatureModes(grabber)
        self._tree = TreeService(grabber, terminal)
        for service, kind, action in (
            ("has_feature", srv.HasFeature, self._has),
            ("get_feature", srv.GetFeature, self._get),
            ("set_feature", srv.SetFeature, self._set),
            ("get_feature_range", srv.GetFeatureRange, self._range),
            ("set_mode", srv.SetMode, self._set_mode),
        ):
            create_service(node, kind, f"~/{service}", _as_callback(action))
        create_service(node, srv.Ask, "~/ask", self._ask)

    def close(self) -> None:
        """Release the grabber."""
        self._tree.close()

    def _has(self, request: Any, answer: Any) -> None:
        if request.name:
            answer.has_feature = self._grabber.has_feature(request.name)
        else:
            answer.has_feature = self._numbers.has(_number(request))
        if answer.has_feature:
            name = self._name(request)
            answer.has_auto = self._modes.has_auto(name)
            answer.has_manual = self._modes.has_manual(name)
            answer.has_one_push = self._modes.has_one_push(name)
            answer.has_on_off = self._modes.has_on_off(name)

    def _get(self, request: Any, answer: Any) -> None:
        feature = self._feature(request)
        self._fill_value(answer, request, feature)
        answer.unit = feature.unit
        answer.active = self._modes.active(feature.name)
        if self._modes.automatic(feature.name):
            answer.mode = FeatureMode.AUTO
        elif feature.auto is not None or self._grabber.offered(feature).access.writable:
            answer.mode = FeatureMode.MANUAL

    def _set(self, request: Any, answer: Any) -> None:
        with self._grabber.exclusive():  # the answer is of the instance that was written
            self._write(request)
            self._fill_value(answer, request, self._feature(request))

    def _write(self, request: Any) -> None:
        name = self._name(request)
        if _is_white_balance(request) and not request.text:
            self._numbers.set_values(request.feature, request.value, request.second_value)
        elif request.name or request.text:
            feature = self._grabber.feature(name)
            is_text = request.text or feature.kind is FeatureKind.STRING
            value = request.text if is_text else _of_kind(feature, request.value)
            self._grabber.write_feature(name, value)
        else:
            self._numbers.set_value(request.feature, request.value)

    def _range(self, request: Any, answer: Any) -> None:
        feature = self._feature(request)
        answer.minimum = float(feature.minimum or 0)
        answer.maximum = float(feature.maximum or 0)
        answer.increment = float(feature.increment or 0)
        answer.unit = feature.unit
        answer.entries = [entry.name for entry in feature.entries if entry.available]
        answer.writable = self._grabber.offered(feature).access.writable

    def _set_mode(self, request: Any, answer: Any) -> None:
        manual, auto, once, on, off = range(1, 6)
        name = self._name(request)
        if request.mode in (manual, auto):
            self._modes.set_automatic(name, request.mode == auto)
        elif request.mode == once:
            self._modes.regulate_once(name)
        elif request.mode in (on, off):
            self._modes.set_active(name, request.mode == on)
        else:
            raise FeatureValueError(f"{name}: mode {request.mode} is none of 1 … 5", name)

    def _feature(self, request: Any) -> Feature:
        """Return the requested feature: by number in SFNC's unit, by name in the camera's."""
        if request.name:
            return self._grabber.feature(request.name)
        return self._numbers.feature(_number(request))

    def _name(self, request: Any) -> str:
        """Return the requested feature's GenICam name. Raises FeatureNotFoundError, UsageError."""
        if request.name:
            return self._grabber.feature(request.name).name
        return self._numbers.require(_number(request))

    def _fill_value(self, answer: Any, request: Any, feature: Feature) -> None:
        if _is_white_balance(request):
            answer.value, answer.second_value = self._numbers.values(request.feature)
            answer.text = f"{format_value(answer.value)} {format_value(answer.second_value)}"
            return
        answer.text = sendable(feature.text)
        answer.value = number_of(feature) or 0.0

    def _ask(self, request: Any, answer: Any) -> Any:
        try:
            answer.result = dumps(self._tree.perform(request.verb, *request.arguments))
            answer.success = True
        except GrabberError as error:
            answer.result, answer.error = sendable(str(error)), type(error).__name__
            answer.feature = getattr(error, "feature", "")
        return answer


def _as_callback(action: Callable[[Any, Any], None]) -> Callable[[Any, Any], Any]:
    """Make a service callback of an action: the reply reports a failure."""

    def serve(request: Any, answer: Any) -> Any:
        try:
            action(request, answer)
            answer.success = True
        except GrabberError as error:
            answer.success, answer.message = False, sendable(str(error))
        return answer

    return serve


def _number(request: Any) -> int:
    """Return YARP's number in a request without a name. Raises UsageError without either."""
    if request.feature < 0:
        raise UsageError("which feature? Give GenICam's name in `name`, or YARP's number in `feature`")
    return int(request.feature)


def _is_white_balance(request: Any) -> bool:
    """Return whether it is about the one feature that has two values."""
    return not request.name and request.feature == FeatureId.WHITE_BALANCE


def _of_kind(feature: Feature, value: float) -> float | bool | str:
    if feature.kind is FeatureKind.BOOLEAN:
        return value != 0
    if feature.kind is FeatureKind.ENUMERATION:
        return entry_at(feature, value)
    return value
