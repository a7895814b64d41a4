"""A grabber on ROS 2: pictures, services, parameters and diagnostics below one name."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.net.ros2.camera_info import read_camera_info
from grabbergui.net.ros2.parameters import FeatureParameters
from grabbergui.net.ros2.pictures import PicturePublisher
from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.net.ros2.services import GrabberServices

log = logging.getLogger(__name__)

DEFAULT_NAME = "/camera"
DIAGNOSTICS_PERIOD = 1.0


class Ros2GrabberServer:
    """Shares an open grabber as a node.

    Topics and services lie below `name`; the node itself has that name, so its parameters are the camera's
    features. What is published costs nothing while nobody listens.
    """

    def __init__(
        self,
        grabber: FrameGrabber,
        name: str = DEFAULT_NAME,
        *,
        frame_id: str = "camera",
        calibration: Path | None = None,
        qos: str = "sensor_data",
        ros_args: Sequence[str] = (),
    ) -> None:
        """Get ready. Raises UsageError for a bad name or `ros_args`, SourceUnavailableError without ROS 2."""
        name = "/" + name.strip("/")
        namespace, _, node_name = name.rpartition("/")
        if not all(part.isidentifier() for part in name.strip("/").split("/")):
            raise UsageError(f"--ros2 {name}: names are of letters, digits and _, as in /head/left")
        self.name = name
        self._grabber = grabber
        self._calibration_file = calibration
        # The parameter services are ours: see FeatureParameters.
        self._ros = Ros2Node(
            node_name, namespace, ros_args=ros_args, enable_rosout=True, start_parameter_services=False
        )
        node = self._ros.node
        # Pictures last: who sees the topic finds the services there already.
        self._services = GrabberServices(node, grabber, name)
        self._parameters = FeatureParameters(node, grabber)
        self._pictures = PicturePublisher(node, grabber, name, frame_id, qos)
        self._serve_camera_info(node)
        self._serve_diagnostics(node)
        self._started_stream = False

    @property
    def published(self) -> int:
        """Pictures published."""
        return self._pictures.published

    def start(self) -> None:
        """Be on the network; start the stream if it is off."""
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
        self._parameters.stop()
        self._services.close()
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
    def _serve_camera_info(self, node: Any) -> None:
        from sensor_msgs.srv import SetCameraInfo

        if self._calibration_file is not None and self._calibration_file.is_file():
            self._pictures.fitted.calibration = Calibration.load(self._calibration_file)
        node.create_service(SetCameraInfo, f"{self.name}/set_camera_info", self._on_set_camera_info)

    def _on_set_camera_info(self, request: Any, answer: Any) -> Any:
        try:
            calibration = read_camera_info(request.camera_info, self.name.rpartition("/")[2])
            if self._calibration_file is not None:
                calibration.save(self._calibration_file)
            self._pictures.fitted.calibration = calibration
            answer.success = True
            where = self._calibration_file or "memory only; start with --calibration FILE to keep it"
            answer.status_message = f"kept in {where}"
        except (GrabberError, OSError) as error:
            answer.success, answer.status_message = False, str(error)
        return answer

    # -- diagnostics ---------------------------------------------------------------------------------
    def _serve_diagnostics(self, node: Any) -> None:
        from diagnostic_msgs.msg import DiagnosticArray

        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        node.create_timer(DIAGNOSTICS_PERIOD, self._publish_diagnostics)

    def _publish_diagnostics(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

        counters = self._grabber.statistics()
        lossy = counters.incomplete or counters.lost
        silent = self._grabber.streaming and counters.frame_rate == 0
        level = DiagnosticStatus.ERROR if silent else DiagnosticStatus.WARN if lossy else DiagnosticStatus.OK
        message = "no frames" if silent else f"{counters.frame_rate:.1f} frames/s"
        facts = {**counters.as_dict(), "published": self.published, "dropped": self._pictures.dropped}
        temperature = Role.TEMPERATURE.find(self._grabber.has_feature)
        if temperature is not None:
            try:
                facts["temperature"] = self._grabber.feature(temperature).value
            except GrabberError as error:
                log.debug("%s: %s", temperature, error)
        array = DiagnosticArray()
        array.header.stamp = self._ros.node.get_clock().now().to_msg()
        array.status = [
            DiagnosticStatus(
                level=level,
                name=f"{self.name.strip('/')}: {self._grabber.info.title}",
                hardware_id=self._grabber.info.serial,
                message=message,
                values=[KeyValue(key=key, value=str(value)) for key, value in facts.items()],
            )
        ]
        self._diagnostics.publish(array)
