"""A camera served as a managed node, driven by the services that `ros2 lifecycle` and launch files call."""

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
lifecycle_msgs = pytest.importorskip("lifecycle_msgs")
pytestmark = pytest.mark.ros2

from lifecycle_msgs.msg import Transition  # noqa: E402
from lifecycle_msgs.srv import ChangeState, GetState  # noqa: E402
from sensor_msgs.msg import Image  # noqa: E402

from grabbergui.core.errors import TransportError  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_peers import until  # noqa: E402


@pytest.fixture
def manager(serve, probe):
    """Serves the camera as a managed node; returns functions that change its state and return its label."""
    server = serve("/cam", lifecycle=True)

    def change(transition):
        return probe.call(ChangeState, "/cam/change_state", transition=Transition(id=transition)).success

    def state():
        return probe.call(GetState, "/cam/get_state").current_state.label

    return server, change, state


def topics(probe):
    return {name for name, _ in probe.node.get_topic_names_and_types() if name.startswith("/cam/image")}


def test_it_sends_while_it_is_active_and_has_topics_while_it_is_configured(manager, camera, probe):
    server, change, state = manager
    assert state() == "unconfigured" and not camera.streaming
    assert not change(Transition.TRANSITION_ACTIVATE), "not before it is configured"
    for _ in range(2):
        assert change(Transition.TRANSITION_CONFIGURE) and state() == "inactive"
        until(lambda: "/cam/image_raw" in topics(probe))
        images = probe.subscribe(Image, "/cam/image_raw", 10)
        assert not camera.streaming
        assert change(Transition.TRANSITION_ACTIVATE) and state() == "active"
        assert images.get(timeout=PATIENCE).width == 320
        assert change(Transition.TRANSITION_DEACTIVATE) and state() == "inactive"
        assert not camera.streaming
        assert change(Transition.TRANSITION_CLEANUP) and state() == "unconfigured"
        until(lambda: not server.published)
    assert change(Transition.TRANSITION_UNCONFIGURED_SHUTDOWN) and state() == "finalized"


def test_an_activation_that_the_camera_refuses_fails_and_can_be_repeated(manager, camera, monkeypatch):
    _, change, state = manager
    assert change(Transition.TRANSITION_CONFIGURE)

    def refuse(**_):
        raise TransportError("the link is down")

    with monkeypatch.context() as patch:
        patch.setattr(camera, "start", refuse)
        assert not change(Transition.TRANSITION_ACTIVATE)
    assert state() == "inactive"
    assert change(Transition.TRANSITION_ACTIVATE) and state() == "active"
    assert change(Transition.TRANSITION_ACTIVE_SHUTDOWN) and state() == "finalized"
    assert not camera.streaming
