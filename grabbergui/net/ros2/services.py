"""The services of `grabber_interfaces`: by YARP's numbers or GenICam names, and the whole tree."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import FeatureNotFoundError, FeatureValueError, GrabberError
from grabbergui.core.features import Feature, FeatureKind, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import AUTO_CONTINUOUS, AUTO_OFF, AUTO_ONCE
from grabbergui.net.feature_json import dumps
from grabbergui.net.ros2.runtime import require_interfaces
from grabbergui.net.tree_service import TreeService
from grabbergui.net.yarp.dev.grabber_features import NumberedFeatures
from grabbergui.net.yarp.dev.grabber_ids import FeatureMode, label


class GrabberServices:
    """Offers the services below a name. Callbacks run on the node's thread; failures are replies."""

    def __init__(self, node: Any, grabber: FrameGrabber, name: str) -> None:
        require_interfaces()
        from grabber_interfaces import srv

        self._grabber = grabber
        self._numbers = NumberedFeatures(grabber)
        self._tree = TreeService(grabber)
        for service, kind, action in (
            ("has_feature", srv.HasFeature, self._has),
            ("get_feature", srv.GetFeature, self._get),
            ("set_feature", srv.SetFeature, self._set),
            ("get_feature_range", srv.GetFeatureRange, self._range),
            ("set_mode", srv.SetMode, self._set_mode),
        ):
            node.create_service(kind, f"{name}/{service}", _told(action))
        node.create_service(srv.Ask, f"{name}/ask", self._ask)

    def close(self) -> None:
        """Let go of the grabber."""
        self._tree.close()

    # -- the five ----------------------------------------------------------------------------------
    def _has(self, request: Any, answer: Any) -> None:
        if request.name:
            answer.has_feature = self._grabber.has_feature(request.name)
            if answer.has_feature:
                feature = self._grabber.feature(request.name)
                auto = self._grabber.feature(feature.auto) if feature.auto else None
                answer.has_auto = auto is not None and _offers(auto, AUTO_CONTINUOUS)
                answer.has_one_push = auto is not None and _offers(auto, AUTO_ONCE)
                answer.has_manual = feature.access.writable or answer.has_auto
                answer.has_on_off = feature.kind is FeatureKind.BOOLEAN
            return
        number = request.feature
        answer.has_feature = self._numbers.has(number)
        if answer.has_feature:
            answer.has_auto = self._numbers.has_auto(number)
            answer.has_manual = self._numbers.has_manual(number)
            answer.has_one_push = self._numbers.has_one_push(number)
            answer.has_on_off = self._numbers.has_on_off(number)

    def _get(self, request: Any, answer: Any) -> None:
        feature = self._feature(request)
        _fill_value(answer, feature)
        answer.unit = feature.unit
        answer.active = True
        if not request.name:
            answer.active = self._numbers.active(request.feature)
        if feature.auto is not None:
            automatic = self._grabber.feature(feature.auto).value not in (AUTO_OFF, False, None)
            answer.mode = FeatureMode.AUTO if automatic else FeatureMode.MANUAL
        elif feature.access.writable:
            answer.mode = FeatureMode.MANUAL

    def _set(self, request: Any, answer: Any) -> None:
        if request.name or request.text:
            feature = self._feature(request)
            value = request.text or _of_kind(feature, request.value)
            _fill_value(answer, self._grabber.write_feature(feature.name, value))
        else:
            self._numbers.set_value(request.feature, request.value)
            _fill_value(answer, self._feature(request))

    def _range(self, request: Any, answer: Any) -> None:
        feature = self._feature(request)
        answer.minimum = float(feature.minimum or 0)
        answer.maximum = float(feature.maximum or 0)
        answer.increment = float(feature.increment or 0)
        answer.unit = feature.unit
        answer.entries = [entry.name for entry in feature.entries if entry.available]
        answer.writable = feature.access.writable

    def _set_mode(self, request: Any, answer: Any) -> None:
        manual, auto, once, on, off = range(1, 6)
        mode = request.mode
        if request.name:
            feature = self._feature(request)
            if mode in (on, off):
                self._grabber.write_feature(feature.name, mode == on)
                return
            if feature.auto is None:
                raise FeatureNotFoundError(
                    f"{feature.name} has no automatic mode on this camera", feature.name
                )
            choices = {manual: AUTO_OFF, auto: AUTO_CONTINUOUS, once: AUTO_ONCE}
            if mode not in choices:
                raise FeatureValueError(f"{feature.name}: mode {mode} is none of 1 … 5", feature.name)
            self._grabber.write_feature(feature.auto, choices[mode])
        elif mode == once:
            self._numbers.one_push(request.feature)
        elif mode in (on, off):
            self._numbers.set_active(request.feature, mode == on)
        else:
            self._numbers.set_mode(request.feature, mode)

    def _feature(self, request: Any) -> Feature:
        if request.name:
            return self._grabber.feature(request.name)
        name = self._numbers.name(request.feature)
        if name is None:
            what = label(request.feature)
            raise FeatureNotFoundError(f"{self._grabber.info.title} has no {what}", what)
        return self._grabber.feature(name)

    # -- the tree ----------------------------------------------------------------------------------
    def _ask(self, request: Any, answer: Any) -> Any:
        try:
            answer.result = dumps(self._tree.perform(request.verb, *request.arguments))
            answer.success = True
        except GrabberError as error:
            answer.result, answer.error = str(error), type(error).__name__
            answer.feature = getattr(error, "feature", "")
        return answer


def _told(action: Callable[[Any, Any], None]) -> Callable[[Any, Any], Any]:
    """An action as a service callback: what fails is said in the reply."""

    def serve(request: Any, answer: Any) -> Any:
        try:
            action(request, answer)
            answer.success = True
        except GrabberError as error:
            answer.success, answer.message = False, str(error)
        return answer

    return serve


def _fill_value(answer: Any, feature: Feature) -> None:
    value = feature.value
    answer.text = format_value(value)
    if feature.kind is FeatureKind.ENUMERATION:
        names = [entry.name for entry in feature.entries]
        answer.value = float(names.index(str(value))) if value in names else 0.0
    elif isinstance(value, (bool, int, float)):
        answer.value = float(value)


def _of_kind(feature: Feature, value: float) -> float | bool | str:
    if feature.kind is FeatureKind.BOOLEAN:
        return value != 0
    if feature.kind is FeatureKind.ENUMERATION:
        if value != int(value) or not 0 <= value < len(feature.entries):
            last = len(feature.entries) - 1
            raise FeatureValueError(f"{feature.name}={value:g}: entries are counted 0 … {last}", feature.name)
        return feature.entries[int(value)].name
    return value


def _offers(feature: Feature, entry: str) -> bool:
    return any(entry == known.name for known in feature.entries)
