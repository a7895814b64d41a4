"""Who publishes a topic, with which quality of service, and whether we get what they send."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

IMAGE_TYPE = "sensor_msgs/msg/Image"
_NAMELESS = "_NODE_NAME_UNKNOWN_"
"""What rmw says of a node whose publisher is seen before its name is."""


@dataclass(frozen=True)
class Publisher:
    """One publisher of a topic."""

    node: str
    "Full name of its node; empty while that is not known."
    topic_type: str
    reliable: bool
    durable: bool
    "Whether it keeps its last messages for those who come late (transient local)."

    @property
    def quality(self) -> str:
        """Its quality of service, for people."""
        return (
            f"{'reliable' if self.reliable else 'best effort'}, "
            f"{'transient local' if self.durable else 'volatile'}"
        )

    def __str__(self) -> str:
        return f"{self.node or 'a nameless node'} ({self.quality})"


def publishers_of(node: Any, topic: str) -> list[Publisher]:
    """Those known just now, in order of their nodes."""
    from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

    found = (
        Publisher(
            "" if _NAMELESS in info.node_name else f"{info.node_namespace.rstrip('/')}/{info.node_name}",
            info.topic_type,
            info.qos_profile.reliability == ReliabilityPolicy.RELIABLE,
            info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        )
        for info in node.get_publishers_info_by_topic(topic)
    )
    return sorted(found, key=str)
