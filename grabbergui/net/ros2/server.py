"""A grabber on ROS 2: pictures, services, parameters and diagnostics below one name."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.ros2.camera_info import read_camera_info
from grabbergui.net.ros2.diagnostics import Diagnostics
from grabbergui.net.ros2.parameters import FeatureParameters
from grabbergui.net.ros2.pictures import PicturePublisher
from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.net.ros2.services import GrabberServices
from grabbergui.net.tree_service import Terminal, no_terminal

log = logging.getLogger(__name__)

DEFAULT_NAME = "/camera"


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
        terminal: Terminal = no_terminal,
    ) -> None:
        """Get ready, as yet unseen. `terminal` runs what is typed to it by the service `ask`.

        Raises UsageError for a bad name, calibration or `ros_args`, OSError where the calibration cannot
        be read, SourceUnavailableError without ROS 2.
        """
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
        self._started_stream = False
        node = self._ros.node
        try:
            # Pictures last: who sees the topic finds the services there already.
            self._services = GrabberServices(node, grabber, name, terminal)
            self._parameters = FeatureParameters(node, grabber)
            self._serve_camera_info(node)
            Diagnostics(node, grabber, name, self._counters)
            self._pictures = PicturePublisher(node, grabber, name, frame_id, qos)
            if calibration is not None and calibration.is_file():
                self._pictures.fitted.calibration = Calibration.load(calibration)
        except BaseException:
            self._ros.close()
            raise

    @property
    def published(self) -> int:
        """Pictures published."""
        return self._pictures.published

    def _counters(self) -> dict[str, int]:
        return {"published": self.published, "dropped": self._pictures.dropped}

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
