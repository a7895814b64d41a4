"""A grabber on ROS 2: images, services, parameters, diagnostics and log of one node."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import Any

from grabbergui.calibration.camera_info import FittedCalibration
from grabbergui.core.errors import AccessDeniedError, FeatureValueError, GrabberError, UsageError
from grabbergui.core.features import Feature, FeatureKind, format_number, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.net.numbered_features import (
    FeatureId,
    FeatureMode,
    FeatureModes,
    NumberedFeatures,
    entry_at,
    number_of,
)
from grabbergui.net.ros2.image_messages import DEFAULT_URL, path_of, read_camera_info
from grabbergui.net.ros2.image_publisher import JPEG_QUALITY, ImagePublisher
from grabbergui.net.ros2.parameters import FeatureParameters
from grabbergui.net.ros2.runtime import (
    Ros2Node,
    RosoutHandler,
    full_name,
    require_interfaces,
    require_ros2,
    sendable,
    steady_timer,
)
from grabbergui.net.tree import Terminal, TreeService, dumps, no_terminal

log = logging.getLogger(__name__)

DEFAULT_NAME = "/camera"


class Ros2GrabberServer:
    """Shares an open grabber as a node.

    Topics and services lie below the node's name, and its parameters are the camera's features. All of them
    move together when `ros_args` rename the node or its namespace. A topic without subscribers costs nothing.
    """

    def __init__(
        self,
        grabber: FrameGrabber,
        name: str = DEFAULT_NAME,
        *,
        frame_id: str = "camera",
        calibration: FittedCalibration | None = None,
        qos: str = "reliable",
        ros_args: Sequence[str] = (),
        read_only: bool = False,
        terminal: Terminal = no_terminal,
    ) -> None:
        """Create the node; nothing is published before `start`.

        `frame_id` is the default of the parameter of that name. `calibration` goes out as `camera_info`, and
        `set_camera_info` replaces it; its file is the default of `camera_info_url`. With `read_only` nobody
        may set them; a `ReadOnlyGrabber` refuses the rest.

        Raises UsageError for a bad name, calibration or `ros_args`, OSError where the calibration cannot be
        read, SourceUnavailableError without ROS 2.
        """
        require_ros2()
        from sensor_msgs.srv import SetCameraInfo

        namespace, _, node_name = full_name(name, f"--ros2 {name}").rpartition("/")
        self._grabber = grabber
        self._calibration = calibration or FittedCalibration(grabber)
        self._read_only = read_only
        # The parameter services are ours: see FeatureParameters.
        self._ros = Ros2Node(
            node_name, namespace, ros_args=ros_args, enable_rosout=True, start_parameter_services=False
        )
        self._started_stream = False
        node = self._ros.node
        self.name: str = node.get_fully_qualified_name()
        "After renaming."
        self._rosout = RosoutHandler(node)
        try:
            self._declare(frame_id)
            self._find_calibration()
            # Images last: a client that sees the topic then finds the services, too.
            self._services = GrabberServices(node, grabber, terminal)
            self._parameters = FeatureParameters(node, grabber, read_only=read_only)
            node.create_service(SetCameraInfo, "~/set_camera_info", self._on_set_camera_info)
            Diagnostics(node, grabber, self._counters)
            self._images = ImagePublisher(node, grabber, qos, self._calibration)
        except BaseException:
            self._rosout.close()
            self._ros.close()
            raise

    @property
    def published(self) -> int:
        """Images published."""
        return self._images.published

    def _counters(self) -> dict[str, int]:
        return {"published": self.published, "dropped": self._images.dropped}

    def start(self) -> None:
        """Join the network; start the stream if it is off."""
        try:
            self._parameters.start()
            if not self._grabber.streaming:
                self._grabber.start()
                self._started_stream = True
        except BaseException:
            self.stop()
            raise
        self._images.start()
        self._ros.start()

    def stop(self) -> None:
        """Leave the network; stop the stream if it was started here. May be called twice."""
        self._images.stop()
        self._calibration.close()
        self._parameters.stop()
        self._services.close()
        self._rosout.close()
        self._ros.close()
        if self._started_stream:
            self._started_stream = False
            try:
                self._grabber.stop()
            except GrabberError as error:
                log.info("stopping the stream: %s", error)

    def __enter__(self) -> Ros2GrabberServer:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    # -- calibration -----------------------------------------------------------------------------
    def _declare(self, frame_id: str) -> None:
        """Declare the parameters that ROS's camera drivers share. Raises UsageError for a wrong value.

        The URL is fixed at the start: otherwise any client could have any file overwritten.
        """
        from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
        from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException

        file = self._calibration.file
        url = file.absolute().as_uri() if file else ""
        quality = [IntegerRange(from_value=1, to_value=100, step=1)]
        for name, value, described in (
            ("frame_id", frame_id, {"description": "Frame of reference in the headers of images."}),
            ("camera_info_url", url, {"description": f"Calibration file; empty: {DEFAULT_URL}"}),
            (JPEG_QUALITY, 90, {"description": "Higher is better and larger.", "integer_range": quality}),
        ):
            fixed = self._read_only or name == "camera_info_url"
            descriptor = ParameterDescriptor(read_only=fixed, **described)
            try:
                self._ros.node.declare_parameter(name, value, descriptor)
            except (InvalidParameterTypeException, InvalidParameterValueException) as error:
                raise UsageError(f"parameter {name}: {error}") from error

    def _find_calibration(self) -> None:
        """Use the file that `camera_info_url` names. Raises UsageError for a URL that names none."""
        url = self._ros.node.get_parameter("camera_info_url").value
        path, present = path_of(url, self.name), self._calibration.file
        if present is None or path.absolute() != present.absolute():
            self._calibration.use(path)

    def _on_set_camera_info(self, request: Any, answer: Any) -> Any:
        try:
            if self._read_only:
                raise AccessDeniedError("the calibration cannot be set: the camera is served read-only")
            calibration = read_camera_info(request.camera_info, self.name.rpartition("/")[2])
            if not self._ros.node.get_parameter("camera_info_url").value:
                path_of("", self.name).parent.mkdir(parents=True, exist_ok=True)
            kept = self._calibration.keep(calibration)
            answer.success, answer.status_message = True, sendable(f"kept in {kept}")
        except (GrabberError, OSError) as error:
            answer.success, answer.status_message = False, sendable(str(error))
        return answer


# -- services ------------------------------------------------------------------------------------
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
            node.create_service(kind, f"~/{service}", _as_callback(action))
        node.create_service(srv.Ask, "~/ask", self._ask)

    def close(self) -> None:
        """Release the grabber."""
        self._tree.close()

    # -- single features -------------------------------------------------------------------------
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
        answer.text = sendable(format_value(feature.value))
        answer.value = number_of(feature) or 0.0

    # -- the tree --------------------------------------------------------------------------------
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


# -- diagnostics ---------------------------------------------------------------------------------
_DIAGNOSTICS_PERIOD = 1.0
"""Seconds."""


class Diagnostics:
    """Publishes one status: an error without frames, a warning while frames are being lost.

    `of_the_network` gives further counters by name. Runs on the node's thread.
    """

    def __init__(
        self, node: Any, grabber: FrameGrabber, of_the_network: Callable[[], dict[str, int]]
    ) -> None:
        from diagnostic_msgs.msg import DiagnosticArray

        self._node = node
        self._grabber = grabber
        self._name = node.get_fully_qualified_name().strip("/")
        self._of_the_network = of_the_network
        self._lost = 0
        "Frames lost or incomplete, when last looked at."
        self._namesake = False
        "Whether another node had this node's name, when last looked at."
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        steady_timer(node, _DIAGNOSTICS_PERIOD, self._publish)

    def _publish(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

        counters = self._grabber.statistics()
        lost = counters.incomplete + counters.lost
        newly, self._lost = max(0, lost - self._lost), lost
        level, message = DiagnosticStatus.OK, f"{counters.frame_rate:.1f} frames/s"
        if self._grabber.lost:
            level, message = DiagnosticStatus.ERROR, f"the camera is lost: {self._grabber.lost}"
        elif self._grabber.streaming and counters.frame_rate == 0:
            level, message = DiagnosticStatus.ERROR, "no frames"
        elif self._has_namesake():
            level, message = DiagnosticStatus.WARN, f"{message}, another node has this name"
        elif newly:
            level, message = DiagnosticStatus.WARN, f"{message}, {newly} lost in the last second"
        facts = {**counters.as_dict(), **self._of_the_network(), **self._temperature()}
        array = DiagnosticArray()
        array.header.stamp = self._node.get_clock().now().to_msg()
        array.status = [
            DiagnosticStatus(
                level=level,
                name=sendable(f"{self._name}: {self._grabber.info.title}"),
                hardware_id=sendable(self._grabber.info.serial),
                message=sendable(message),
                values=[KeyValue(key=key, value=format_number(value)) for key, value in facts.items()],
            )
        ]
        self._publisher.publish(array)

    def _has_namesake(self) -> bool:
        """Return whether another node has this node's name; log when one appears. ROS does not prevent it."""
        namespace, name = self._node.get_namespace(), self._node.get_name()
        found: bool = self._node.get_node_names_and_namespaces().count((name, namespace)) > 1
        if found and not self._namesake:
            log.warning(
                "another node is called /%s, or was killed in the last 20 s: if it runs, images of both mix, "
                "and either answers requests; end it, or choose another name (--ros2, -r __node:=NAME)",
                self._name,
            )
        self._namesake = found
        return found

    def _temperature(self) -> dict[str, float]:
        """Return where the camera measures it: degrees Celsius, or what an old camera counts in."""
        try:
            name = self._grabber.role(Role.TEMPERATURE)
            value = self._grabber.feature(name).value if name else None
        except GrabberError as error:  # the camera is lost, or closed before its server
            log.debug("temperature: %s", error)
            return {}
        return {"temperature": float(value)} if isinstance(value, (int, float)) else {}
