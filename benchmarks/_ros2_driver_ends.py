"""The other processes of `ros2_drivers`: the camera, and readers and an operator independent of both drivers.

Times are nanoseconds of the system's monotonic clock. Each process obeys messages on its pipe. Readers and
operator use plain rclpy and nothing of this project.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from benchmarks._network_runs import Size
    from grabbergui.driver.sim.settings import FrameSettings

ADDRESS = "127.68.0.9"
PACKET_SIZE = 8164
EXPOSURE_US = 10_000.0
PATIENCE = 30.0
"Seconds that a driver has to open the camera."
OPENING = 1.0
"""Seconds from a driver's publisher to the first subscription: camera_aravis2 1.2 misses a subscription
while it opens the camera, and then never starts the stream."""


@dataclass(frozen=True)
class Watched:
    """Exposures and writes of the camera between `"begin"` and `"end"`."""

    exposures: list[tuple[int, int]]
    "First pixel of each image, and the start of its exposure."
    gains: list[int]
    "Times of writes of GainRaw."


def be_camera(pipe: Connection, size: Size) -> None:
    """Simulate a GigE Vision camera whose images are distinguished by their first pixel.

    Sends one message when ready; answers `"begin"` with None and `"end"` with a `Watched`; None ends it.
    """
    from grabbergui.core.pfnc import by_name
    from grabbergui.driver.sim import registers as reg
    from grabbergui.driver.sim.enumerations import TestPattern
    from grabbergui.driver.sim.gige import registers as gev
    from grabbergui.driver.sim.gige.server import GigeCamera
    from grabbergui.driver.sim.sensor import Sensor

    exposures: list[tuple[int, int]] = []
    gains: list[int] = []

    class RecordingSensor(Sensor):
        """Records when each image is exposed."""

        def render(
            self, settings: FrameSettings, frame_id: int, time_ns: int, out: NDArray[Any]
        ) -> NDArray[Any]:
            began = time.monotonic_ns() - (camera.model.timestamp() - time_ns)
            values = super().render(settings, frame_id, time_ns, out)
            exposures.append((int(values[0, 0]), began))
            return values

    camera = GigeCamera(
        ADDRESS,
        power_on={
            reg.OFFSET_X: 0,
            reg.OFFSET_Y: 0,
            reg.WIDTH: size.width,
            reg.HEIGHT: size.height,
            reg.PIXEL_FORMAT: by_name("Mono8").code,
            reg.TEST_PATTERN: int(TestPattern.GREY_HORIZONTAL_RAMP_MOVING),
            reg.FRAME_RATE_ENABLE: 1,
            reg.FRAME_RATE: size.rate,
            reg.EXPOSURE_TIME: EXPOSURE_US,
        },
    )
    # As most cameras: camera_aravis2 opens every stream channel, and each gets every frame.
    camera.control.memory.set(gev.STREAM_CHANNELS, 1)
    camera.model.sensor = RecordingSensor()
    camera.model.memory.on_written(reg.GAIN_RAW, lambda: gains.append(time.monotonic_ns()))
    pipe.send(None)
    while (order := pipe.recv()) is not None:
        if order == "begin":
            exposures.clear()
            gains.clear()
            pipe.send(None)
        else:
            pipe.send(Watched(list(exposures), list(gains)))
    camera.close()


@dataclass(frozen=True)
class Seen:
    """The images that one reader has received since `"join"`."""

    arrivals: list[tuple[int, int]]
    "First pixel of each image, and the time at which it was complete."
    cores: float
    "CPU seconds per second."


def read(pipe: Connection, number: int, topic: str) -> None:
    """Read images like any rclpy program, with the default quality of service (reliable, depth 10).

    `"join"` waits for the driver and answers whether a first image arrived; `"seen"` answers with a `Seen`
    from then on.
    """
    from sensor_msgs.msg import Image

    arrivals: list[tuple[int, int]] = []

    def take(message: Any) -> None:
        arrivals.append((message.data[0], time.monotonic_ns()))

    with _node(f"reader{number}") as node:
        pipe.send(None)
        cpu, since = 0.0, time.monotonic()
        while (order := pipe.recv()) is not None:
            if order == "join":
                arrivals.clear()
                _until(lambda: node.count_publishers(topic) > 0)
                time.sleep(OPENING)
                node.create_subscription(Image, topic, take, 10)
                came = _until(lambda: bool(arrivals))
                cpu, since = time.process_time(), time.monotonic()
                pipe.send(came)
            else:
                cores = (time.process_time() - cpu) / (time.monotonic() - since)
                pipe.send(Seen(list(arrivals), cores))


@dataclass(frozen=True)
class Set:
    """The times of one parameter's change."""

    began: int
    answered: int


def operate(pipe: Connection, service: str, writes: int) -> None:
    """Set the parameter `Gain` repeatedly on request, like `ros2 param set`.

    Sends one message when ready, and one `Set` for each write; None ends it.
    """
    from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
    from rcl_interfaces.srv import SetParameters

    with _node("operator") as node:
        client = node.create_client(SetParameters, service)
        pipe.send(None)
        while pipe.recv() is not None:
            assert _until(lambda: bool(client.service_is_ready())), f"nobody offers {service}"
            done = []
            for number in range(writes):
                time.sleep(0.1)
                value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=0.5 + number % 2)
                request = SetParameters.Request(parameters=[Parameter(name="Gain", value=value)])
                began, answered = time.monotonic_ns(), threading.Event()
                future = client.call_async(request)
                future.add_done_callback(lambda _, answered=answered: answered.set())
                assert answered.wait(PATIENCE), "the driver did not answer"
                until = time.monotonic_ns()
                result = future.result().results[0]
                assert result.successful, f"Gain was refused: {result.reason}"
                done.append(Set(began, until))
            pipe.send(done)


@contextmanager
def _node(name: str) -> Iterator[Any]:
    """Run a node that spins in a thread of its own."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    rclpy.init()
    node = rclpy.create_node(name, start_parameter_services=False)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    ended = threading.Event()

    def spin() -> None:
        while not ended.is_set():
            executor.spin_once(timeout_sec=0.1)

    thread = threading.Thread(target=spin)
    thread.start()
    try:
        yield node
    finally:
        ended.set()
        thread.join()
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def _until(true: Callable[[], bool]) -> bool:
    deadline = time.monotonic() + PATIENCE
    while not true():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.005)
    return True
