"""A grabber on ROS 2: images, services, parameters, diagnostics and log of one node."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from functools import partial
from typing import Any

from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.core.camera_info_message import read_camera_info
from grabbergui.core.errors import AccessDeniedError, GrabberError, UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.readers import Reader
from grabbergui.net.ros2 import compressed_topics
from grabbergui.net.ros2.diagnostics import Diagnostics
from grabbergui.net.ros2.grabber_services import GrabberServices
from grabbergui.net.ros2.image_messages import DEFAULT_URL, path_of
from grabbergui.net.ros2.image_publisher import ImagePublisher
from grabbergui.net.ros2.lifecycle import ManagedImages
from grabbergui.net.ros2.parameters import FeatureParameters
from grabbergui.net.ros2.requirements import require_ros2
from grabbergui.net.ros2.rosout import RosoutHandler
from grabbergui.net.ros2.runtime import Ros2Node, check_frame_id, full_name, sendable
from grabbergui.net.ros2.standard_services import StandardServices
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
        domain: int | None = None,
        read_only: bool = False,
        lifecycle: bool = False,
        terminal: Terminal = no_terminal,
    ) -> None:
        """Create the node; nothing is published before `start`.

        `frame_id` is the default of the parameter of that name. `calibration` goes out as `camera_info`, and
        `set_camera_info` replaces it; its file is the default of `camera_info_url`. With `read_only` nobody
        may set them; a `ReadOnlyGrabber` refuses the rest. `domain` is that of ROS_DOMAIN_ID by default.
        With `lifecycle` it is a managed node, and the stream is started when that is activated.

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
            node_name,
            namespace,
            ros_args=ros_args,
            domain=domain,
            lifecycle=lifecycle,
            enable_rosout=True,
            start_parameter_services=False,
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
            if not read_only:
                StandardServices(node, grabber)
            self._parameters = FeatureParameters(node, grabber, read_only=read_only)
            node.create_service(SetCameraInfo, "~/set_camera_info", self._on_set_camera_info)
            Diagnostics(node, grabber, self._counters)
            images = partial(ImagePublisher, node, grabber, qos, self._calibration)
            self._managed = (
                ManagedImages(node, images, self._start_stream, self._stop_stream) if lifecycle else None
            )
            self._only = None if lifecycle else images()
        except BaseException:
            self._rosout.close()
            self._ros.close()
            raise

    @property
    def _images(self) -> ImagePublisher | None:
        """The publisher; None while a managed node is not configured."""
        return self._only if self._managed is None else self._managed.images

    @property
    def published(self) -> int:
        """Images published; of a managed node, since it was configured."""
        images = self._images
        return 0 if images is None else images.published

    def connected(self) -> list[Reader]:
        """Return who subscribes to images. ROS 2 does not report who calls services. Any thread."""
        images = self._images
        return [] if images is None else images.readers()

    def places(self) -> list[str]:
        """Return the topics of the images as display text, with the domain."""
        return [f"{self.name}/image_raw in domain {self._ros.domain}"]

    def _counters(self) -> dict[str, int]:
        images = self._images
        return {"published": self.published, "dropped": 0 if images is None else images.dropped}

    def start(self) -> None:
        """Join the network; start the stream if it is off, unless the node is managed."""
        try:
            self._parameters.start()
            self._calibration.assume_settings()
            if self._only is not None:
                self._start_stream()
        except BaseException:
            self.stop()
            raise
        if self._only is not None:
            self._only.start()
        self._ros.start()

    def stop(self) -> None:
        """Leave the network; stop the stream if it was started here. May be called twice."""
        if (images := self._images) is not None:
            images.stop()
        self._calibration.close()
        self._parameters.stop()
        self._services.close()
        self._rosout.close()
        self._ros.close()
        self._stop_stream()

    def _start_stream(self) -> None:
        """Start the stream if it is off. Raises GrabberError."""
        if not self._grabber.streaming:
            self._grabber.start()
            self._started_stream = True

    def _stop_stream(self) -> None:
        """Stop the stream if it was started here."""
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

    def _declare(self, frame_id: str) -> None:
        """Declare the parameters that ROS's camera drivers share. Raises UsageError for a wrong value.

        The URL is fixed at the start: otherwise any client could have any file overwritten.
        """
        from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
        from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException

        def check(parameters: list[Any]) -> Any:
            for parameter in parameters:
                try:
                    if parameter.name == "frame_id" and isinstance(parameter.value, str):
                        check_frame_id(parameter.value)
                    compressed_topics.check(parameter.name, parameter.value)
                except UsageError as error:
                    return SetParametersResult(successful=False, reason=sendable(str(error)))
            return SetParametersResult(successful=True)

        self._ros.node.add_on_set_parameters_callback(check)
        file = self._calibration.file
        url = file.absolute().as_uri() if file else ""
        for name, value, described in (
            ("frame_id", frame_id, {"description": "Frame of reference in the headers of images."}),
            ("camera_info_url", url, {"description": f"Calibration file; empty: {DEFAULT_URL}"}),
            *compressed_topics.parameters(),
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
