"""Nodes that know nothing of ours, for tests with real rclpy."""

import queue
import time

from grabbergui.net.ros2.runtime import Ros2Node, quality_of_service
from patience import PATIENCE, until

__all__ = ["Probe", "patiently", "until"]


def patiently(send):
    """The result of the future that `send` gives.

    A service that took a request before it has met the reader of its answers drops these: ask again.
    """
    for _ in range(20):
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
        assert client.wait_for_service(PATIENCE), f"no service {service}"
        return patiently(lambda: client.call_async(kind.Request(**request)))


class ParameterProbe(Probe):
    """Another's node with rclpy's client of one node's parameters."""

    def __init__(self, node):
        from rclpy.parameter_client import AsyncParameterClient

        # A name of its own: the graph cannot tell the clients of two nodes of one name apart.
        super().__init__(f"parameter_probe{node.replace('/', '_')}")
        self._client = AsyncParameterClient(self.node, node)
        assert self._client.wait_for_services(PATIENCE)

    def names(self, *arguments):
        return patiently(lambda: self._client.list_parameters(*arguments)).result.names

    def values(self, *names):
        return patiently(lambda: self._client.get_parameters(list(names))).values

    def types(self, *names):
        return list(patiently(lambda: self._client.get_parameter_types(list(names))).types)

    def describe(self, *names):
        return patiently(lambda: self._client.describe_parameters(list(names))).descriptors

    def set(self, **values):
        parameters = _parameters(values)
        return patiently(lambda: self._client.set_parameters(parameters)).results

    def set_together(self, **values):
        parameters = _parameters(values)
        return patiently(lambda: self._client.set_parameters_atomically(parameters)).result

    def set_message(self, message):
        return patiently(lambda: self._client.set_parameters([message])).results[0]

    def load(self, path):
        return patiently(lambda: self._client.load_parameter_file(str(path))).results


def _parameters(values):
    from rclpy.parameter import Parameter

    return [Parameter(name, value=value) for name, value in values.items()]
