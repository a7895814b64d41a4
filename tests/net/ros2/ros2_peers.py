"""Nodes that know nothing of ours, for tests with real rclpy."""

import queue
import time

from grabbergui.net.ros2.runtime import Ros2Node, quality_of_service


def until(condition, seconds=10.0):
    """Wait until a condition holds, and give what it was."""
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline, "it never came to hold"
        time.sleep(0.005)
    return found


def patiently(send):
    """The result of the future that `send` gives.

    A service that took a request before it has met the reader of its answers drops these: ask again.
    """
    for _ in range(5):
        future = send()
        deadline = time.monotonic() + 3
        while not future.done() and time.monotonic() < deadline:
            time.sleep(0.002)
        if future.done():
            return future.result()
    raise AssertionError("there was no answer")


class Probe:
    """An independent node: subscribes, and calls services."""

    def __init__(self, name="probe"):
        self.ros = Ros2Node(name)
        self.node = self.ros.node
        self.ros.start()
        self._clients = {}

    def close(self):
        self.ros.close()

    def subscribe(self, kind, topic, qos=None):
        received = queue.Queue()
        qos = quality_of_service("sensor_data") if qos is None else qos
        self.node.create_subscription(kind, topic, received.put, qos)
        return received

    def call(self, kind, service, /, **request):
        """The answer of a service, which must come within ten seconds."""
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, service)
        client = self._clients[service]
        assert client.wait_for_service(10), f"no service {service}"
        return patiently(lambda: client.call_async(kind.Request(**request)))
