"""Services of a TIAGo's other nodes: its description, its controllers' list, the start of MoveIt Servo."""

from __future__ import annotations

import logging
import queue
import time
from typing import Any

from grabbergui.core.errors import TransportError
from grabbergui.net.ros2.runtime import Ros2Node, load_type_support
from grabbergui.servo.robots.tiago_parts import Controller

log = logging.getLogger(__name__)

LIST = "/controller_manager/list_controllers"
PERIOD = 0.5
"Seconds between two looks at the list."
ANSWER_S = 2.0
"Seconds to wait for MoveIt Servo's services."


def receive_description(timeout: float = 3.0) -> str:
    """Wait for the URDF that robot_state_publisher latches on `/robot_description`; empty if none comes."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    received: queue.Queue[str] = queue.Queue()
    ros = Ros2Node(f"grabbergui_description_{time.time_ns() % 10**9}")
    try:
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        ros.node.create_subscription(
            String, "/robot_description", lambda message: received.put(message.data), latched
        )
        ros.start()
        return received.get(timeout=timeout)
    except queue.Empty:
        return ""
    finally:
        ros.close()


class ControllerManager:
    """Keeps the list of controllers up to date. The list is read on the node's thread, used on any."""

    def __init__(self, node: Any) -> None:
        self._listed: list[Controller] | None = None
        self._client: Any = None
        self._pending: Any = None
        try:
            import controller_manager_msgs
            from controller_manager_msgs.srv import ListControllers
        except ImportError:
            log.info("controller_manager_msgs is not installed: whoever listens is taken for a controller")
            return
        load_type_support(controller_manager_msgs)
        self._request = ListControllers.Request()
        self._client = node.create_client(ListControllers, LIST)
        node.create_timer(PERIOD, self._ask)
        self._ask()

    @property
    def can_ask(self) -> bool:
        """Whether the messages to ask with are installed."""
        return self._client is not None

    def listed(self) -> list[Controller] | None:
        """The newest list; None while no controller manager has answered."""
        return self._listed

    def state_of(self, name: str) -> str | None:
        """A controller's state, `not loaded` if it is not in the list; None without a list."""
        if self._listed is None:
            return None
        return next((one.state for one in self._listed if one.name == name), "not loaded")

    def _ask(self) -> None:
        if self._pending is None and self._client.service_is_ready():
            self._pending = self._client.call_async(self._request)
            self._pending.add_done_callback(self._on_answer)

    def _on_answer(self, future: Any) -> None:
        self._pending = None
        self._listed = [
            Controller(
                row.name,
                row.type,
                row.state,
                tuple(row.claimed_interfaces or row.required_command_interfaces),
            )
            for row in future.result().controller
        ]


def start_servo_node(node: Any, twists: str) -> None:
    """Have the MoveIt Servo node that listens to `twists` obey them; nothing if it offers no services.

    Humble has `start_servo` (Trigger); later releases have `switch_command_type` and `pause_servo` (SetBool).
    Raises TransportError where it refuses or does not answer.
    """
    prefix = twists.rpartition("/")[0]
    offered = dict(node.get_service_names_and_types())
    kinds = {
        name.removeprefix(f"{prefix}/"): types[0]
        for name, types in offered.items()
        if name.startswith(f"{prefix}/")
    }
    if "start_servo" in kinds:
        from std_srvs.srv import Trigger

        _call(node, Trigger, f"{prefix}/start_servo", Trigger.Request())
    if "switch_command_type" in kinds:
        _switch_to_twists(node, f"{prefix}/switch_command_type")
    if kinds.get("pause_servo") == "std_srvs/srv/SetBool":
        from std_srvs.srv import SetBool

        _call(node, SetBool, f"{prefix}/pause_servo", SetBool.Request(data=False))


def _switch_to_twists(node: Any, service: str) -> None:
    try:
        import moveit_msgs
        from moveit_msgs.srv import ServoCommandType
    except ImportError:
        log.warning("moveit_msgs is not installed: %s has to be called with 1 (TWIST) by hand", service)
        return
    load_type_support(moveit_msgs)
    request = ServoCommandType.Request(command_type=ServoCommandType.Request.TWIST)
    _call(node, ServoCommandType, service, request)


def _call(node: Any, kind: Any, service: str, request: Any) -> None:
    client = node.create_client(kind, service)
    try:
        if not client.wait_for_service(ANSWER_S):
            raise TransportError(f"{service} is not there any more")
        future = client.call_async(request)
        deadline = time.monotonic() + ANSWER_S
        while not future.done():
            if time.monotonic() > deadline:
                raise TransportError(f"{service} does not answer")
            time.sleep(0.01)
        answer = future.result()
        if not answer.success:
            raise TransportError(f"{service} refused: {getattr(answer, 'message', '') or 'no reason given'}")
    finally:
        node.destroy_client(client)
