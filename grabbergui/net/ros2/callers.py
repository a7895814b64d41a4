"""Who calls a service: ROS 2 does not say, but its graph lists the nodes that have a client of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grabbergui.core.requester import requested_by

NETWORK = "ROS 2"
MOST_NAMED = 3
"More nodes than these are not listed, as any of them may have called."

Callback = Callable[[Any, Any], Any]
"Called with request and answer; returns the answer."


def create_service(node: Any, kind: Any, name: str, callback: Callback, **options: Any) -> None:
    """Create a service whose callback runs as `requested_by` its caller, as far as that is known."""
    service = node.resolve_service_name(name)

    def attributed(request: Any, answer: Any) -> Any:
        with requested_by(caller_of(node, service)):
            return callback(request, answer)

    node.create_service(kind, name, attributed, **options)


def caller_of(node: Any, service: str) -> str:
    """Return the node that has a client of a service of `node`, as `/name`.

    If several have one, any of them may have called: `ROS 2: /one, /other`. `ROS 2` if there are many, or
    none that discovery knows.
    """
    names = []
    own = node.get_fully_qualified_name()
    for name, namespace in node.get_node_names_and_namespaces():
        full = f"{namespace.rstrip('/')}/{name}"
        if full != own and full not in names and _has_client(node, name, namespace, service):
            names.append(full)
    if len(names) == 1:
        return str(names[0])
    return f"{NETWORK}: {', '.join(sorted(names))}" if 1 < len(names) <= MOST_NAMED else NETWORK


def _has_client(node: Any, name: str, namespace: str, service: str) -> bool:
    from rclpy.node import NodeNameNonExistentError

    try:
        clients = node.get_client_names_and_types_by_node(name, namespace)
    except NodeNameNonExistentError:  # it has ended meanwhile
        return False
    return any(client == service for client, _ in clients)
