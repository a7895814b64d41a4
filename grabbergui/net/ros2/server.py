"""A grabber on ROS 2: images, services, parameters, diagnostics and log of one node."""

from __future__ import annotations

import logging
import math
import queue
import threading
from collections.abc import Callable, Sequence
from typing import Any

from typing_extensions import override

from grabbergui.calibration.camera_info import FittedCalibration
from grabbergui.core.errors import AccessDeniedError, GrabberError, UsageError
from grabbergui.core.features import format_number
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.net.ros2.image_messages import DEFAULT_URL, path_of, read_camera_info
from grabbergui.net.ros2.parameters import FeatureParameters
from grabbergui.net.ros2.pictures import PicturePublisher
from grabbergui.net.ros2.runtime import Ros2Node, require_ros2
from grabbergui.net.ros2.services import GrabberServices
from grabbergui.net.tree import Terminal, no_terminal

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

        name = "/" + name.strip("/")
        namespace, _, node_name = name.rpartition("/")
        if not all(part.isidentifier() for part in name.strip("/").split("/")):
            raise UsageError(f"--ros2 {name}: names are of letters, digits and _, as in /head/left")
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
            # Images last: who sees the topic finds the services there already.
            self._services = GrabberServices(node, grabber, terminal)
            self._parameters = FeatureParameters(node, grabber)
            node.create_service(SetCameraInfo, "~/set_camera_info", self._on_set_camera_info)
            Diagnostics(node, grabber, self._counters)
            self._pictures = PicturePublisher(node, grabber, qos, self._calibration)
        except BaseException:
            self._rosout.close()
            self._ros.close()
            raise

    @property
    def published(self) -> int:
        """Images published."""
        return self._pictures.published

    def _counters(self) -> dict[str, int]:
        return {"published": self.published, "dropped": self._pictures.dropped}

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
        self._pictures.start()
        self._ros.start()

    def stop(self) -> None:
        """Leave the network; stop the stream if it was started here. May be called twice."""
        self._pictures.stop()
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

    # -- calibration ---------------------------------------------------------------------------------
    def _declare(self, frame_id: str) -> None:
        """Declare the two parameters that ROS's camera drivers share. Raises UsageError for a wrong type.

        The URL is fixed at the start: otherwise any client could have any file overwritten.
        """
        from rcl_interfaces.msg import ParameterDescriptor
        from rclpy.exceptions import InvalidParameterTypeException

        file = self._calibration.file
        for name, value, fixed, description in (
            ("frame_id", frame_id, self._read_only, "Frame of reference in the headers of images."),
            (
                "camera_info_url",
                file.absolute().as_uri() if file else "",
                True,
                f"Calibration file; empty: {DEFAULT_URL}",
            ),
        ):
            descriptor = ParameterDescriptor(description=description, read_only=fixed)
            try:
                self._ros.node.declare_parameter(name, value, descriptor)
            except InvalidParameterTypeException as error:
                raise UsageError(f"parameter {name}: {error}") from error

    def _find_calibration(self) -> None:
        """Use the file that `camera_info_url` names. One that nobody asked for is no reason to stop."""
        url = self._ros.node.get_parameter("camera_info_url").value
        try:
            self._calibration.use(path_of(url, self.name))
        except (UsageError, OSError) as error:
            if url:
                raise
            log.warning("images are published without calibration: %s", error)

    def _on_set_camera_info(self, request: Any, answer: Any) -> Any:
        try:
            if self._read_only:
                raise AccessDeniedError("the calibration cannot be set: the camera is served read-only")
            calibration = read_camera_info(request.camera_info, self.name.rpartition("/")[2])
            if not self._ros.node.get_parameter("camera_info_url").value:
                path_of("", self.name).parent.mkdir(parents=True, exist_ok=True)
            answer.success, answer.status_message = True, f"kept in {self._calibration.keep(calibration)}"
        except (GrabberError, OSError) as error:
            answer.success, answer.status_message = False, str(error)
        return answer


PERIOD = 1.0
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
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        node.create_timer(PERIOD, self._publish)

    def _publish(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

        counters = self._grabber.statistics()
        lost = counters.incomplete + counters.lost
        newly, self._lost = max(0, lost - self._lost), lost
        level, message = DiagnosticStatus.OK, f"{counters.frame_rate:.1f} frames/s"
        if self._grabber.streaming and counters.frame_rate == 0:
            level, message = DiagnosticStatus.ERROR, "no frames"
        elif newly:
            level, message = DiagnosticStatus.WARN, f"{message}, {newly} lost in the last second"
        facts = {**counters.as_dict(), **self._of_the_network(), **self._temperature()}
        array = DiagnosticArray()
        array.header.stamp = self._node.get_clock().now().to_msg()
        array.status = [
            DiagnosticStatus(
                level=level,
                name=f"{self._name}: {self._grabber.info.title}",
                hardware_id=self._grabber.info.serial,
                message=message,
                values=[KeyValue(key=key, value=format_number(value)) for key, value in facts.items()],
            )
        ]
        self._publisher.publish(array)

    def _temperature(self) -> dict[str, float]:
        """Return where the camera measures it: degrees Celsius, or what an old camera counts in."""
        try:
            name = Role.TEMPERATURE.find(self._grabber.has_feature)
            value = self._grabber.feature(name).value if name else None
        except GrabberError as error:  # the camera is lost, or closed before its server
            log.debug("temperature: %s", error)
            return {}
        return {"temperature": float(value)} if isinstance(value, (int, float)) else {}


MOST_WAITING = 100
"""Records that wait to be published; more than that at once, and the rest is only in the log."""


class RosoutHandler(logging.Handler):
    """Publishes what the package logs, from warnings on, as long as it is open.

    Records come from any thread, which never waits for the network: a thread of the handler publishes them.
    """

    def __init__(self, node: Any) -> None:
        super().__init__(logging.WARNING)
        from rcl_interfaces.msg import Log
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self._message = Log
        self._node = node
        # As rcl's own publisher for it: a console that is started later sees the last of them too.
        quality = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._publisher = node.create_publisher(Log, "/rosout", quality)
        self._records: queue.Queue[logging.LogRecord | None] = queue.Queue(MOST_WAITING)
        self._thread = threading.Thread(target=self._run, name="ros2 rosout", daemon=True)
        self._thread.start()
        logging.getLogger("grabbergui").addHandler(self)

    @override
    def emit(self, record: logging.LogRecord) -> None:
        try:
            self._records.put_nowait(record)
        except queue.Full:
            return

    def close(self) -> None:
        """Publish what waits, and stop. May be called twice."""
        logging.getLogger("grabbergui").removeHandler(self)
        if self._thread.is_alive():
            self._records.put(None)
            self._thread.join()
        super().close()

    def _run(self) -> None:
        while (record := self._records.get()) is not None:
            self._publisher.publish(self._log(record))

    def _log(self, record: logging.LogRecord) -> Any:
        fraction, seconds = math.modf(record.created)
        message = self._message(
            level=min(record.levelno, logging.CRITICAL),  # ROS numbers them as Python does
            name=self._node.get_logger().name,
            msg=record.getMessage(),
            file=record.filename,
            function=record.funcName or "",
            line=record.lineno,
        )
        message.stamp.sec, message.stamp.nanosec = int(seconds), int(fraction * 1e9)
        return message
