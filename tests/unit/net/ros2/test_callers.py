"""The caller of a service, by ROS 2's graph."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")

from rclpy.node import NodeNameNonExistentError

from grabbergui.core.requester import requester
from grabbergui.net.ros2.callers import caller_of, create_service

SERVICE = "/cam/set_parameters"


class GraphNode:
    """The node `/cam`, and others with clients of these services; None: a node that ends meanwhile."""

    def __init__(self, **others):
        self.others = others
        self.services = {}

    def get_fully_qualified_name(self):
        return "/cam"

    def get_node_names_and_namespaces(self):
        return [("cam", "/"), *((name, "/lab") for name in self.others)]

    def get_client_names_and_types_by_node(self, name, namespace):
        if self.others.get(name, ()) is None:
            raise NodeNameNonExistentError(name)
        services = [SERVICE] if name == "cam" else self.others[name]
        return [(service, ["rcl_interfaces/srv/SetParameters"]) for service in services]

    def resolve_service_name(self, name):
        return name.replace("~", "/cam")

    def create_service(self, kind, name, callback, **options):
        self.services[name] = callback


@pytest.mark.parametrize(
    ("others", "author"),
    [
        ({"rqt": [SERVICE], "viewer": ["/other/set_parameters"]}, "/lab/rqt"),
        ({"rqt": [SERVICE], "cli": [SERVICE]}, "ROS 2: /lab/cli, /lab/rqt"),
        ({"gone": None, "rqt": [SERVICE]}, "/lab/rqt"),
        ({}, "ROS 2"),
        ({f"node{number}": [SERVICE] for number in range(4)}, "ROS 2"),
    ],
)
def test_a_caller_is_the_node_that_has_a_client(others, author):
    assert caller_of(GraphNode(**others), SERVICE) == author


def test_what_a_service_changes_is_its_callers():
    node, seen = GraphNode(rqt=[SERVICE]), []

    def callback(request, answer):
        seen.append(requester())
        return answer

    create_service(node, None, "~/set_parameters", callback)
    assert node.services["~/set_parameters"]("request", "answer") == "answer"
    assert seen == ["/lab/rqt"]
    assert requester() == ""
