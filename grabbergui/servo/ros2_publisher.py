"""Publishes the loop's detections and state on ROS 2, and accepts a stop from any peer.

Topics below a prefix: `head` and `marker` (`geometry_msgs/PoseStamped`: the nearest head, the target marker
or board), `marker_with_covariance` (`geometry_msgs/PoseWithCovarianceStamped`: the same with its covariance),
`state` (`diagnostic_msgs/DiagnosticStatus`: state, reason, errors), and if vision_msgs is installed `heads`
and `markers` (`vision_msgs/Detection3DArray`, the id in `id`, with covariances). Poses are in the camera's
optical frame. Services: `stop` and `resume` (`std_srvs/Trigger`); a message on `stop_now` (`std_msgs/Empty`)
stops, too, for peers that cannot wait for an answer.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Pose, pose
from grabbergui.core.frame import Frame
from grabbergui.net.ros2.camera_pose import fill_pose
from grabbergui.net.ros2.requirements import require_packages
from grabbergui.net.ros2.runtime import Ros2Node, full_name
from grabbergui.servo.detection import Sighting
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.measured_errors import errors
from grabbergui.servo.runner import Runner
from grabbergui.servo.state_machine import State

HEAD_SIZE = (0.19, 0.25, 0.2)
"Assumed size of a head, metres: only its place is measured."

log = logging.getLogger(__name__)
_Thing = tuple[str, Pose, tuple[float, float, float], "NDArray[np.float64] | None"]
"Name, pose, size in metres, and the pose's covariance, None if it is not known."


class Ros2Publisher:
    """Publishes one runner. `open` and `close` from one thread; stops arrive on the node's."""

    def __init__(self, runner: Runner, name: str = "/grabbergui/servo", frame_id: str = "camera") -> None:
        """`frame_id` is the camera's frame. Raises UsageError for a bad name."""
        namespace, _, node_name = full_name(name, name).rpartition("/")
        self._runner = runner
        self._frame_id = frame_id
        self._name = (namespace, node_name)
        self._ros: Ros2Node | None = None
        self._publishers: dict[str, Any] = {}

    def open(self) -> None:
        """Join the network and start to publish. Raises SourceUnavailableError without ROS 2."""
        require_packages("diagnostic_msgs.msg", "geometry_msgs.msg", "std_msgs.msg", "std_srvs.srv")
        namespace, node_name = self._name
        self._ros = Ros2Node(node_name, namespace)
        from diagnostic_msgs.msg import DiagnosticStatus
        from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
        from std_msgs.msg import Empty
        from std_srvs.srv import Trigger

        node, prefix = self._ros.node, f"{namespace}/{node_name}"
        kinds = {"head": PoseStamped, "marker": PoseStamped, "state": DiagnosticStatus}
        kinds["marker_with_covariance"] = PoseWithCovarianceStamped
        kinds |= dict.fromkeys(("heads", "markers"), _detections()) if _detections() else {}
        self._publishers = {name: node.create_publisher(kinds[name], f"{prefix}/{name}", 5) for name in kinds}
        node.create_service(Trigger, f"{prefix}/stop", self._on_stop)
        alone = MutuallyExclusiveCallbackGroup()  # stops are handled while it waits
        node.create_service(Trigger, f"{prefix}/resume", self._on_resume, callback_group=alone)
        node.create_subscription(Empty, f"{prefix}/stop_now", self._on_stop_now, 1)
        self._ros.start()
        self._runner.cycle_done.connect(self._on_cycle)

    def close(self) -> None:
        """Leave the network. May be called twice; never raises."""
        self._runner.cycle_done.disconnect(self._on_cycle, missing_ok=True)
        ros, self._ros = self._ros, None
        if ros is not None:
            ros.close()

    def _on_stop(self, request: Any, answer: Any) -> Any:
        self._runner.emergency_stop("stopped over ROS 2", "ROS 2")
        answer.success, answer.message = True, "stopped; call resume to continue"
        return answer

    async def _on_resume(self, request: Any, answer: Any) -> Any:
        """Resume on a thread of its own, as the guardian takes a second to start again."""
        from rclpy.task import Future

        assert self._ros is not None
        was_stopped = bool(self._runner.gate.halted)
        ended: Future[str] = Future(executor=self._ros.node.executor)
        resume = partial(self._runner.resume, pressed="ROS 2")
        threading.Thread(target=lambda: ended.set_result(resume()), daemon=True).start()
        why_not = await ended
        answer.success = not why_not
        answer.message = why_not or ("resumed" if was_stopped else "it was not stopped")
        return answer

    def _on_stop_now(self, message: Any) -> None:
        self._runner.emergency_stop("stopped over ROS 2", "ROS 2")

    def _on_cycle(self, cycle: ControlCycle, frame: Frame | None) -> None:
        self._publish("state", lambda: status(cycle))
        sighting = self._runner.loop.sighting
        if frame is None or sighting is None:
            return
        seconds, nanoseconds = divmod(frame.received_ns, 1_000_000_000)

        def header(message: Any) -> Any:
            message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
            message.header.frame_id = self._frame_id
            return message

        nearest, wanted = sighting.nearest_face, sighting.only(self._runner.config.marker.target)
        if nearest is not None:
            self._publish("head", lambda: header(pose_stamped(pose(translation=nearest.position))))
        if wanted is not None and wanted.pose is not None:
            seen, covariance = wanted.pose, wanted.covariance
            self._publish("marker", lambda: header(pose_stamped(seen)))
            if covariance is not None:
                self._publish(
                    "marker_with_covariance", lambda: header(pose_with_covariance(seen, covariance))
                )
        self._publish("heads", lambda: header(heads_array(sighting)))
        extent = self._runner.config.marker.extent
        self._publish("markers", lambda: header(markers_array(sighting, extent)))

    def _publish(self, name: str, make: Any) -> None:
        """Publish a message; make it only if the topic has a subscriber."""
        publisher = self._publishers.get(name)
        if publisher is None:
            return
        try:
            if publisher.get_subscription_count():
                publisher.publish(make())
        except Exception as error:  # the network must not hold up the loop, whatever it raises
            log.warning("%s is not published: %s", name, error)


def pose_stamped(placed: Pose) -> Any:
    """Encode a pose, with an empty header."""
    from geometry_msgs.msg import PoseStamped

    message = PoseStamped()
    _fill(message.pose, placed)
    return message


def pose_with_covariance(placed: Pose, covariance: NDArray[np.float64]) -> Any:
    """Encode a pose and its (6, 6) covariance, with an empty header."""
    from geometry_msgs.msg import PoseWithCovarianceStamped

    message = PoseWithCovarianceStamped()
    _fill(message.pose.pose, placed)
    message.pose.covariance = np.ravel(covariance).astype(np.float64)
    return message


def status(cycle: ControlCycle) -> Any:
    """Encode state, reason and `errors` as ROS's diagnostics."""
    from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

    values = {"state": cycle.state.value} | {name: f"{value:.3f}" for name, value in errors(cycle).items()}
    levels = {
        State.STOPPED: DiagnosticStatus.ERROR,
        State.LOST: DiagnosticStatus.WARN,
        State.STUCK: DiagnosticStatus.WARN,
    }
    return DiagnosticStatus(
        level=levels.get(cycle.state, DiagnosticStatus.OK),
        name="visual servoing",
        hardware_id="",
        message=cycle.reason,
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )


def heads_array(sighting: Sighting) -> Any:
    """Encode all heads as `vision_msgs/Detection3DArray`; their distance is rough."""
    found = [("head", pose(translation=head.position), HEAD_SIZE, None) for head in sighting.faces]
    return _array(found)


def markers_array(sighting: Sighting, extent: tuple[float, float]) -> Any:
    """Encode all markers with a pose; `extent` is their width and height in metres."""
    flat = (*extent, 0.0)
    return _array(
        [(str(m.marker_id), m.pose, flat, m.covariance) for m in sighting.markers if m.pose is not None]
    )


def _array(things: Sequence[_Thing]) -> Any:
    from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose

    message = Detection3DArray()
    for name, placed, size, covariance in things:
        detection, hypothesis = Detection3D(id=name), ObjectHypothesisWithPose()
        hypothesis.hypothesis.class_id, hypothesis.hypothesis.score = name, 1.0
        _fill(hypothesis.pose.pose, placed)
        _fill(detection.bbox.center, placed)
        if covariance is not None:
            hypothesis.pose.covariance = np.ravel(covariance).astype(np.float64)
        detection.bbox.size.x, detection.bbox.size.y, detection.bbox.size.z = size
        detection.results = [hypothesis]
        message.detections.append(detection)
    return message


def _fill(message: Any, placed: Pose) -> None:
    fill_pose(message.position, message.orientation, placed)


def _detections() -> Any:
    """Return the message's type; None if vision_msgs is not installed."""
    try:
        from vision_msgs.msg import Detection3DArray
    except ImportError:
        return None
    return Detection3DArray
