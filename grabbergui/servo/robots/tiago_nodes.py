"""Other nodes of TIAGo: its description, controller manager, MoveIt Servo, and programs that move it, too."""

from __future__ import annotations

import logging
import queue
import time
from collections.abc import Callable, Collection
from typing import Any

from grabbergui.core.errors import SourceUnavailableError, TransportError
from grabbergui.net.ros2.client_link import publishers_of
from grabbergui.net.ros2.requirements import load_type_support
from grabbergui.net.ros2.runtime import DISCOVERY_S, Ros2Node, steady_timer
from grabbergui.servo.robots.tiago_choice import Controller

log = logging.getLogger(__name__)

_LIST = "/controller_manager/list_controllers"
_LIST_S = 0.5
"Seconds between two requests for the list."
_ANSWER_S = 2.0
"Seconds to wait for MoveIt Servo's services, and for a list after the first."
_MOST_PENDING = 4
"Requests for the list that may be pending; beyond that the oldest is removed."
NODE = "grabbergui_servo_"
"Beginning of our nodes' names."
GUARDIAN = "grabbergui_guardian_"
"Beginning of the names of our guardians' nodes."
JOIN_S = 1.0
"Seconds for which DDS discovers other programs before their absence counts."
_UNNAMED = "a node that has just joined"
"A publisher is discovered before the name of its node, and commands arrive before either."
_WATCH_S = 0.1
"Seconds between two looks for other programs."


def receive_description(timeout: float = DISCOVERY_S) -> str:
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
    """Keeps the list of controllers up to date, on the node's thread. Methods may be called on any."""

    def __init__(self, node: Any) -> None:
        self._listed: list[Controller] | None = None
        self._client: Any = None
        self._pending: list[Any] = []
        "Requests without an answer, oldest first."
        self._asked = 0.0
        try:
            import controller_manager_msgs
            from controller_manager_msgs.srv import ListControllers
        except ImportError:
            log.info("controller_manager_msgs is not installed: any subscriber counts as a controller")
            return
        load_type_support(controller_manager_msgs)
        self._request = ListControllers.Request()
        self._client = node.create_client(ListControllers, _LIST)
        steady_timer(node, _LIST_S, self._ask)
        self._ask()

    @property
    def can_ask(self) -> bool:
        """Whether the controller manager's messages are installed."""
        return self._client is not None

    @property
    def awaited(self) -> bool:
        """Whether there is a controller manager that has not answered yet."""
        return self._client is not None and self._listed is None and bool(self._client.service_is_ready())

    def listed(self) -> list[Controller] | None:
        """Return the newest list; None before a controller manager has answered."""
        return self._listed

    def state_of(self, name: str) -> str | None:
        """Return a controller's state, `not loaded` if it is not in the list; None without a list."""
        if self._listed is None:
            return None
        return next((one.state for one in self._listed if one.name == name), "not loaded")

    def _ask(self) -> None:
        """Request the list unless an answer is due.

        An answer is lost if the manager ends, or if it has not discovered this client's reader yet.
        """
        now = time.monotonic()
        patience = _LIST_S if self._listed is None else _ANSWER_S
        if (self._pending and now - self._asked < patience) or not self._client.service_is_ready():
            return
        while len(self._pending) >= _MOST_PENDING:
            self._client.remove_pending_request(self._pending.pop(0))
        self._asked = now
        future = self._client.call_async(self._request)
        self._pending.append(future)
        future.add_done_callback(self._on_answer)

    def _on_answer(self, future: Any) -> None:
        pending, self._pending = self._pending, []
        for other in pending:
            if other is not future:
                self._client.remove_pending_request(other)
        self._listed = [
            Controller(
                row.name,
                row.type,
                row.state,
                tuple(row.claimed_interfaces or row.required_command_interfaces),
            )
            for row in future.result().controller
        ]


class OtherPrograms:
    """Watches for another servo program that commands the same parts: a stop here would not stop them.

    DDS may discover the robot before another program, and a publisher before the name of its node.
    """

    def __init__(self, ros: Ros2Node, robot: str) -> None:
        """To be made when the node has joined; `robot` is its name for messages."""
        self._ros, self._robot = ros, robot
        self._joined = time.monotonic()
        self._topics: Collection[str] = ()
        self._found = ""
        self._strangers: frozenset[str] = frozenset()

    def refuse(self, topics: Collection[str]) -> None:
        """Raise SourceUnavailableError if there is one on these topics of commands.

        Returns `JOIN_S` after the node has joined, and waits for names, which publishers without ROS lack.
        """
        self._topics = topics
        time.sleep(max(self._joined + JOIN_S - time.monotonic(), 0))
        # Since now: the other program may have joined long after this one.
        self._ros.discovered(lambda: "" not in self._commanders(), since=time.monotonic())
        if other := _servo_program(self._commanders()):
            raise SourceUnavailableError(
                f"another servo program, node {other}, commands {self._robot}: end it first; one that was "
                "killed is forgotten after 20 s"
            )

    def watch(self, disturbed: Callable[[], None]) -> None:
        """Look again every `_WATCH_S`, on the node's thread, for one that was discovered late.

        `disturbed` is called there while `strangers` publish commands.
        """

        def look() -> None:
            self._look()
            if self._strangers:
                disturbed()

        steady_timer(self._ros.node, _WATCH_S, look)

    def require_none(self) -> None:
        """Raise TransportError if one has been discovered since; does not wait."""
        if self._found:
            raise TransportError(
                f"another servo program, node {self._found}, commands {self._robot}, too: end one"
            )

    @property
    def strangers(self) -> frozenset[str]:
        """The nodes that publish commands of these parts, guardians apart, when they were last looked for."""
        return self._strangers

    def _look(self) -> None:
        commanders = self._commanders()
        self._found = _servo_program(commanders)
        others = (name or _UNNAMED for name in commanders if not name.startswith(GUARDIAN))
        self._strangers = frozenset(others)

    def _commanders(self) -> set[str]:
        """Return the names of the nodes that publish commands, without this one; empty while unknown."""
        node = self._ros.node
        found = (publisher.node for topic in self._topics for publisher in publishers_of(node, topic))
        return {name.rpartition("/")[2] for name in found} - {node.get_name()}


def _servo_program(names: Collection[str]) -> str:
    return next((name for name in sorted(names) if name.startswith(NODE)), "")


class ServoNode:
    """The MoveIt Servo node that subscribes to `twists`, as far as it offers services.

    Humble has `start_servo` and `stop_servo` (Trigger); later releases have `switch_command_type` and
    `pause_servo` (SetBool).
    """

    def __init__(self, ros: Ros2Node, twists: str) -> None:
        """Waits until the services are discovered, if there are any."""
        self.paused = False
        "Whether `pause` was called since the last `start`."
        self._node, self._prefix = ros.node, twists.rpartition("/")[0]
        self._kinds: dict[str, str] = {}
        self._pausing: Any = None
        ros.discovered(self._discovered)

    def start(self) -> None:
        """Make it obey twists. Raises TransportError if it refuses or does not answer."""
        from std_srvs.srv import SetBool, Trigger

        self.paused = False
        if "start_servo" in self._kinds:
            self._call(Trigger, "start_servo", Trigger.Request())
        if "switch_command_type" in self._kinds:
            _switch_to_twists(self._node, f"{self._prefix}/switch_command_type")
        if self._has_pause:
            self._call(SetBool, "pause_servo", SetBool.Request(data=False))
        if self._pausing is None and self._has_pause:
            self._pausing = self._node.create_client(SetBool, f"{self._prefix}/pause_servo")
        elif self._pausing is None and "stop_servo" in self._kinds:
            self._pausing = self._node.create_client(Trigger, f"{self._prefix}/stop_servo")

    def pause(self) -> bool:
        """Make it ignore twists, whoever sends them, without waiting; return whether it can."""
        if self._pausing is None:
            return False
        request = self._pausing.srv_type.Request()
        if self._has_pause:
            request.data = True
        self._pausing.call_async(request)
        self.paused = True
        return True

    @property
    def _has_pause(self) -> bool:
        return self._kinds.get("pause_servo") == "std_srvs/srv/SetBool"

    def _call(self, kind: Any, service: str, request: Any) -> None:
        _call(self._node, kind, f"{self._prefix}/{service}", request)

    def _discovered(self) -> bool:
        offered = self._node.get_service_names_and_types()
        prefix = f"{self._prefix}/"
        self._kinds |= {
            name.removeprefix(prefix): kinds[0] for name, kinds in offered if name.startswith(prefix)
        }
        kinds = self._kinds.keys()
        return {"start_servo", "stop_servo"} <= kinds or {"switch_command_type", "pause_servo"} <= kinds


def _switch_to_twists(node: Any, service: str) -> None:
    try:
        import moveit_msgs
        from moveit_msgs.srv import ServoCommandType
    except ImportError:
        log.warning("moveit_msgs is not installed: call %s with 1 (TWIST) yourself", service)
        return
    load_type_support(moveit_msgs)
    request = ServoCommandType.Request(command_type=ServoCommandType.Request.TWIST)
    _call(node, ServoCommandType, service, request)


def _call(node: Any, kind: Any, service: str, request: Any) -> None:
    client = node.create_client(kind, service)
    try:
        if not client.wait_for_service(_ANSWER_S):
            raise TransportError(f"{service} is not there any more")
        future = client.call_async(request)
        deadline = time.monotonic() + _ANSWER_S
        while not future.done():
            if time.monotonic() > deadline:
                raise TransportError(f"{service} does not answer")
            time.sleep(0.01)
        answer = future.result()
        if not answer.success:
            raise TransportError(f"{service} refused: {getattr(answer, 'message', '') or 'no reason given'}")
    finally:
        node.destroy_client(client)
