"""Who subscribes to a served camera, and how much is published for them."""

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from sensor_msgs.msg import Image  # noqa: E402

from grabbergui.core.errors import SourceUnavailableError  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_domain import own_domain  # noqa: E402
from ros2_peers import until  # noqa: E402


def test_a_subscriber_is_named_with_what_is_published_for_it(server, probe):
    assert server.connected() == []
    images = probe.subscribe(Image, "/cam/image_raw")
    size = len(images.get(timeout=PATIENCE).data)
    reader = until(lambda: [reader for reader in server.connected() if reader.images > 1])[0]
    assert reader.takes == "/cam/image_raw"
    assert reader.name == probe.node.get_fully_qualified_name()
    assert reader.bytes == reader.images * size


def test_the_place_names_the_domain_which_may_be_given(server, camera):
    domain = int(own_domain()["ROS_DOMAIN_ID"])
    assert server.places() == [f"/cam/image_raw in domain {domain}"]
    given = Ros2GrabberServer(camera, "/elsewhere", domain=domain + 101)
    given.stop()
    assert given.places() == [f"/elsewhere/image_raw in domain {domain + 101}"]


def test_a_domain_without_ports_is_refused(camera):
    with pytest.raises(SourceUnavailableError, match="domains have numbers from 0 to 232"):
        Ros2GrabberServer(camera, "/elsewhere", domain=233)
