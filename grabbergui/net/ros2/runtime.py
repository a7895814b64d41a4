"""One ROS 2 node with the thread of its callbacks, and its log; what to do without ROS 2."""

from __future__ import annotations

import atexit
import logging
import os
import re
import threading
import time
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from grabbergui.core.errors import AccessDeniedError, SourceUnavailableError, UsageError
from grabbergui.core.shared_folder import MEMORY
from grabbergui.core.visible_text import visible
from grabbergui.net.ros2 import shared_memory as memory
from grabbergui.net.ros2.requirements import require_ros2

log = logging.getLogger(__name__)

QUEUE_DEPTH = 5
"""Images that a publisher or subscription keeps, as in ROS's own profile for sensors."""
_PROFILES = "FASTDDS_DEFAULT_PROFILES_FILE"
_OURS = "<transport_id>images</transport_id>"
"""Part of our profile with shared memory; copies of the profile have it too."""
LAST_DOMAIN = 232
"""Highest ROS_DOMAIN_ID: the UDP ports of a higher one would be beyond 65535."""
_RANGE, _LOCALHOST_ONLY = "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY"
"""How far nodes discover each other; the second is that of Humble, which Kilted no longer reads."""
DISCOVERY_S = 4.0
"""Seconds within which a node discovers the others, their names and services.

Messages of Fast DDS's discovery that were lost are repeated after 3 s."""
AT_EXIT_S = 2.0
"Seconds for which the end of the program waits for a callback."


_FULL_NAME = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+")


MOST_FRAME_ID = 255
"Bytes of a frame's name; each image carries it, and viewers and logs show it."


def check_frame_id(text: str) -> None:
    """Raise UsageError for a text that is no name of a frame; the empty one stands for no frame."""
    size = len(text.encode("utf-8", "surrogatepass"))
    if size > MOST_FRAME_ID or not text.isprintable() or " " in text:
        raise UsageError(
            f"frame_id '{visible(text[:40])}{'…' if len(text) > 40 else ''}' ({size} bytes): write at most "
            f"{MOST_FRAME_ID} bytes of printable characters without spaces, such as camera_optical_frame"
        )


def full_name(text: str, what: str) -> str:
    """Return the name of a node or topic, with one slash before it.

    Raises UsageError, whose text begins with `what`; rclpy raises errors of various classes for names
    that ROS does not allow.
    """
    name = "/" + text.strip("/")
    if not _FULL_NAME.fullmatch(name):
        raise UsageError(
            f"{what}: names on ROS 2 are of letters, digits and _ and begin with no digit, as in /head/left"
        )
    return name


class Ros2Node:
    """A node in a context of its own, spun by one thread until closed.

    Callbacks run on that thread. Signals are left to the program.
    """

    def __init__(
        self,
        name: str,
        namespace: str = "",
        *,
        ros_args: Sequence[str] = (),
        domain: int | None = None,
        shared_memory: bool = True,
        lifecycle: bool = False,
        **options: Any,
    ) -> None:
        """Join the network. Raises SourceUnavailableError without ROS 2, UsageError for bad `ros_args`.

        `ros_args` are what ROS's programs take behind `--ros-args`: `-r`, `-p`, `--params-file` …
        `domain` is that of ROS_DOMAIN_ID by default.
        With `lifecycle` it is a managed node.
        Without `shared_memory` the first node of a process decides that it sends by UDP alone.
        """
        require_ros2()
        _require_domain(os.environ.get("ROS_DOMAIN_ID", "") if domain is None else str(domain))
        use_transports(shared_memory=shared_memory)
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions

        self.context = rclpy.Context()
        # ROS's log file, one for each process, would stay empty: our messages go to stderr and /rosout.
        arguments = ["--ros-args", "--disable-external-lib-logs", *ros_args]
        try:
            rclpy.init(
                args=arguments,
                context=self.context,
                domain_id=domain,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            create = _managed_node if lifecycle else rclpy.create_node
            self.node = create(name, namespace=namespace or None, context=self.context, **options)
        except (RuntimeError, ValueError) as error:
            self.context.try_shutdown()
            if not ros_args and isinstance(error, RuntimeError):
                raise SourceUnavailableError(f"ROS 2 cannot start: {_without_places(error)}") from error
            if not ros_args:
                raise
            raise UsageError(f"--ros-args {' '.join(ros_args)}: {_without_places(error)}") from error
        self.domain: int = self.context.get_domain_id()
        "The domain that the node has joined."
        memory.keep_private()
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._joined = time.monotonic()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._spin, name=f"ros2 {name}", daemon=True)

    def start(self) -> None:
        """Let callbacks run from now on."""
        # Python ends a thread that is still in rclpy by unwinding C++, which ends the program by `terminate`.
        atexit.register(self._end_thread, AT_EXIT_S)
        self._thread.start()

    def discovered(self, condition: Callable[[], bool], since: float | None = None) -> bool:
        """Wait until a condition holds; return whether it does in the end.

        The wait ends `DISCOVERY_S` after this node joined the network, or after `since` (`time.monotonic`).
        """
        deadline = (self._joined if since is None else since) + DISCOVERY_S
        while not (holds := condition()) and time.monotonic() < deadline:
            time.sleep(0.02)
        return holds

    def close(self) -> None:
        """End the thread and leave the network. May be called twice."""
        if self._closed.is_set():
            return
        atexit.unregister(self._end_thread)
        self._end_thread()
        self._executor.remove_node(self.node)
        self.node.destroy_node()
        self._executor.shutdown()
        self.context.try_shutdown()

    def _end_thread(self, timeout: float | None = None) -> None:
        self._closed.set()
        # A task ends the wait for callbacks immediately; `wake` alone does not.
        self._executor.create_task(lambda: None)
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(timeout)

    def _spin(self) -> None:
        from rclpy.exceptions import InvalidHandle
        from rclpy.executors import ExternalShutdownException

        while not self._closed.is_set():
            try:
                self._executor.spin_once(timeout_sec=0.2)
            except ExternalShutdownException:
                return
            except InvalidHandle as error:
                # Another thread ended a subscription or client for which an event was waiting.
                log.debug("%s: %s", self._thread.name, error)
            except Exception:
                # One failed callback must not stop the others.
                log.exception("%s: a callback failed", self._thread.name)


def _managed_node(name: str, **options: Any) -> Any:
    from rclpy.lifecycle import LifecycleNode

    return LifecycleNode(name, **options)


def steady_timer(node: Any, seconds: float, callback: Callable[[], None], **options: Any) -> Any:
    """Return a timer of a node that neither `use_sim_time` nor a change of the system's time stops."""
    from rclpy.clock import Clock

    kinds = type(node.get_clock().clock_type)  # which each release of rclpy has in another module
    return node.create_timer(seconds, callback, clock=Clock(clock_type=kinds.STEADY_TIME), **options)


def _require_domain(text: str) -> None:
    """Raise SourceUnavailableError for a domain that UDP has no ports for: Fast DDS would end the program."""
    number = text.strip().lstrip("+0")
    if number.isdecimal() and (len(number) > 3 or int(number) > LAST_DOMAIN):
        raise SourceUnavailableError(
            f"ROS_DOMAIN_ID={text[:9]}: domains have numbers from 0 to {LAST_DOMAIN}"
        )


def sendable(text: str) -> str:
    """Return a text with `?` for what was no UTF-8, as in names of files and YARP's texts: ROS refuses it."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _without_places(error: Exception) -> str:
    """Return ROS's message without places in its source; for unknown arguments ROS only lists them."""
    text = re.sub(r",? at /\S+?:\d+", "", str(error)).removeprefix("failed to initialize rcl: ")
    if "log directory" in text:
        text += "; ROS_LOG_DIR may name a folder that can be written"
    return f"unknown: {text}" if text.startswith("[") else text


def quality_of_service(name: str, *, latched: bool = False) -> Any:
    """Return a fresh quality of service by name: `sensor_data` (best effort, the default) or `reliable`.

    A `latched` publisher keeps its last message for those who subscribe later (transient local).
    """
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    policies = {"sensor_data": ReliabilityPolicy.BEST_EFFORT, "reliable": ReliabilityPolicy.RELIABLE}
    if name not in policies:
        raise UsageError(f"quality of service '{name}': write {' or '.join(policies)}")
    if latched:
        return QoSProfile(depth=1, reliability=policies[name], durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return QoSProfile(depth=QUEUE_DEPTH, reliability=policies[name])


def use_transports(*, shared_memory: bool) -> None:
    """Choose how Fast DDS finds and sends; a user's own profile stays. It reads this once per process.

    Shared memory gets room for images. UDP alone is safer: a program that freezes while it holds the lock of
    a shared-memory port never releases it. UDP is also used beside another user's programs: Fast DDS prefers
    shared memory even then, neither user can open the other's, and nothing arrives.
    """
    if os.environ.get("ROS_DISCOVERY_SERVER"):
        # A plain client learns only of topics that it subscribes to, and would find no camera.
        os.environ.setdefault("ROS_SUPER_CLIENT", "TRUE")
    if os.environ.get(_LOCALHOST_ONLY) == "1":
        os.environ.setdefault(_RANGE, "LOCALHOST")
    folder = resources.files("grabbergui.resources") / "ros2"
    chosen = os.environ.get(_PROFILES)
    if chosen is not None and not _is_ours(chosen):
        if why := memory.irregular():
            raise SourceUnavailableError(f"ROS 2 cannot start with the profile of {_PROFILES}: {why}")
        return
    against = memory.reason_against() if shared_memory else ""
    if against:
        log.info("nothing is sent in shared memory, but by UDP: %s", against)
    if shared_memory and not against:
        _clear_leftovers()
        os.environ[_PROFILES] = chosen or str(folder / "fastdds.xml")
    elif os.environ.get(_RANGE) == "LOCALHOST":
        # In this range rmw adds shared memory to any transports; the profile keeps to this machine instead.
        loopback = str(folder / "fastdds-loopback.xml")
        os.environ.update({_RANGE: "SUBNET", _LOCALHOST_ONLY: "0", _PROFILES: loopback})
    else:
        os.environ[_PROFILES] = str(folder / "fastdds-network.xml")


def _clear_leftovers() -> None:
    try:
        removed = memory.clear(memory.leftovers(MEMORY, own=True))
    except AccessDeniedError as error:
        log.debug("shared memory of killed programs stays: %s", error)
        return
    if removed:
        log.info("removed %s of shared memory that killed programs left", memory.megabytes(removed))


def _is_ours(profiles: str) -> bool:
    """Whether this is our profile, set by the program that started this one, or a copy with other room."""
    try:
        return _OURS in Path(profiles).read_text("utf-8")
    except (OSError, UnicodeDecodeError):
        return False
