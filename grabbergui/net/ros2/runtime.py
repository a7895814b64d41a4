"""One ROS 2 node with a thread that runs its callbacks; and what to do where ROS 2 is missing."""

from __future__ import annotations

import os
import threading
from importlib import resources
from typing import Any

from grabbergui.core.errors import SourceUnavailableError, UsageError

HOW_TO_GET_IT = "ROS 2 is not installed: run `make setup-ros2`, or source the system's setup.bash first"
_PROFILES = "FASTDDS_DEFAULT_PROFILES_FILE"


def require_ros2() -> None:
    """Raise SourceUnavailableError, in one line, where rclpy is missing."""
    try:
        import rclpy  # noqa: F401
    except ImportError as error:
        raise SourceUnavailableError(f"{HOW_TO_GET_IT} ({error})") from error


def require_interfaces() -> None:
    """Raise SourceUnavailableError, in one line, where our services' package is missing."""
    try:
        import grabber_interfaces.srv  # noqa: F401
    except ImportError as error:
        raise SourceUnavailableError(
            f"the package grabber_interfaces is not built: run `make setup-ros2` ({error})"
        ) from error


class Ros2Node:
    """A node in a context of its own, spun by one thread until closed.

    Callbacks run on that thread. Signals are left to the program.
    """

    def __init__(self, name: str, namespace: str = "", **options: Any) -> None:
        """Raises SourceUnavailableError without ROS 2."""
        require_ros2()
        use_transport_profile()
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions

        self.context = rclpy.Context()
        rclpy.init(context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node(name, namespace=namespace or None, context=self.context, **options)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._spin, name=f"ros2 {name}", daemon=True)

    def start(self) -> None:
        """Let callbacks run from now on."""
        self._thread.start()

    def close(self) -> None:
        """End the thread and leave the network. May be called twice."""
        if self._closed.is_set():
            return
        self._closed.set()
        self._executor.wake()
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join()
        self._executor.remove_node(self.node)
        self.node.destroy_node()
        self._executor.shutdown()
        self.context.try_shutdown()

    def _spin(self) -> None:
        while not self._closed.is_set():
            self._executor.spin_once(timeout_sec=0.2)


def quality_of_service(name: str) -> Any:
    """A quality of service by name: `sensor_data` (best effort, the default) or `reliable`."""
    from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data

    if name == "sensor_data":
        return qos_profile_sensor_data
    if name == "reliable":
        return QoSProfile(depth=5, reliability=ReliabilityPolicy.RELIABLE)
    raise UsageError(f"quality of service '{name}': write sensor_data or reliable")


def use_transport_profile() -> None:
    """Give Fast DDS room for pictures in shared memory, unless the user has a profile of his own."""
    if _PROFILES not in os.environ:
        profile = resources.files("grabbergui.resources") / "ros2" / "fastdds.xml"
        os.environ[_PROFILES] = str(profile)
