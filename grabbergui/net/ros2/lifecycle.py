"""A served camera as a managed node: https://design.ros2.org/articles/node_lifecycle.html.

Services, parameters and diagnostics are there in every state, so the camera can be tuned before it sends.
*configure* makes the topics, *activate* starts the stream and publishes, *deactivate* stops both, *cleanup*
removes the topics. A transition that the camera refuses fails, and the node keeps its state.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.net.ros2.image_publisher import ImagePublisher

log = logging.getLogger(__name__)


class ManagedImages:
    """The images of a managed node. Transitions run on the node's thread."""

    def __init__(
        self,
        node: Any,
        create: Callable[[], ImagePublisher],
        start_stream: Callable[[], None],
        stop_stream: Callable[[], None],
    ) -> None:
        """`start_stream` raises GrabberError."""
        self._node, self._create = node, create
        self._start_stream, self._stop_stream = start_stream, stop_stream
        self.images: ImagePublisher | None = None
        "None while the node is not configured."
        self._others: set[Any] = set()
        "The node's publishers of other things."
        node.add_managed_entity(_entity(self))

    def configure(self) -> None:
        """Make the topics."""
        self._others = set(self._node.publishers)
        self.images = self._create()
        self.images.enabled = False
        self.images.start()

    def activate(self) -> None:
        """Publish. Raises GrabberError if the stream cannot be started."""
        self._start_stream()
        if self.images is not None:
            self.images.enabled = True

    def deactivate(self) -> None:
        """Publish nothing."""
        if self.images is not None:
            self.images.enabled = False
        self._stop_stream()

    def clean_up(self) -> None:
        """Remove the topics. May be called twice."""
        images, self.images = self.images, None
        if images is None:
            return
        images.stop()
        for publisher in set(self._node.publishers) - self._others:
            self._node.destroy_publisher(publisher)

    def shut_down(self) -> None:
        """Publish nothing and remove the topics, in any state."""
        self.deactivate()
        self.clean_up()


def _entity(images: ManagedImages) -> Any:
    """Return what rclpy calls on transitions."""
    from rclpy.lifecycle import ManagedEntity, TransitionCallbackReturn

    def transition(work: Callable[[], None]) -> Callable[[Any], Any]:
        def run(_: Any) -> Any:
            try:
                work()
            except GrabberError as error:
                log.error("%s", error)
                return TransitionCallbackReturn.FAILURE
            return TransitionCallbackReturn.SUCCESS

        return run

    entity = ManagedEntity()
    entity.on_configure = transition(images.configure)
    entity.on_activate = transition(images.activate)
    entity.on_deactivate = transition(images.deactivate)
    entity.on_cleanup = transition(images.clean_up)
    entity.on_shutdown = entity.on_error = transition(images.shut_down)
    return entity
