"""Served read-only, a camera is changed by no parameter, service or topic of its node."""

from contextlib import closing

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from grabber_interfaces import srv  # noqa: E402
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue  # noqa: E402
from rcl_interfaces.srv import SetParameters, SetParametersAtomically  # noqa: E402
from sensor_msgs.msg import CameraInfo, Image  # noqa: E402
from sensor_msgs.srv import SetCameraInfo  # noqa: E402

from grabbergui.core.shared import ReadOnlyGrabber  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from grabbergui.terminal import remote_terminal  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_peers import ParameterProbe, Probe, until  # noqa: E402

READING = {
    "describe_parameters",
    "get_feature",
    "get_feature_range",
    "get_parameter_types",
    "get_parameters",
    "get_type_description",
    "has_feature",
    "list_parameters",
}
SETTING = {
    "ask": [
        (srv.Ask, {"verb": "write", "arguments": ["Gain", "3"]}),
        (srv.Ask, {"verb": "set", "arguments": ["Gain", "3"]}),
        (srv.Ask, {"verb": "execute", "arguments": ["AcquisitionStop"]}),
        (srv.Ask, {"verb": "terminal", "arguments": ["stop"]}),
    ],
    "set_camera_info": [(SetCameraInfo, {"camera_info": CameraInfo(width=320, height=240)})],
    "set_feature": [
        (srv.SetFeature, {"name": "Gain", "value": 3.0}),
        (srv.SetFeature, {"feature": 3, "value": 1.5, "second_value": 1.6}),
        (srv.SetFeature, {"name": "PixelFormat", "text": "Mono8"}),
    ],
    "set_mode": [(srv.SetMode, {"name": "Gain", "mode": mode}) for mode in range(1, 6)],
    "set_parameters": [],
    "set_parameters_atomically": [],
}
"Services with requests that change something, if they can; parameters have a test of their own."
OTHER = {
    ParameterType.PARAMETER_BOOL: lambda value: ParameterValue(type=1, bool_value=not value.bool_value),
    ParameterType.PARAMETER_INTEGER: lambda value: ParameterValue(
        type=2, integer_value=value.integer_value + 8
    ),
    ParameterType.PARAMETER_DOUBLE: lambda value: ParameterValue(type=3, double_value=value.double_value + 1),
    ParameterType.PARAMETER_STRING: lambda value: ParameterValue(
        type=4, string_value=value.string_value + "x"
    ),
}
"A value of the same type that differs, by type."


@pytest.fixture
def server(camera, domain):
    camera.start()
    shown = ReadOnlyGrabber(camera)
    shown.open()
    with (
        closing(shown),
        Ros2GrabberServer(shown, "/shown", read_only=True, terminal=remote_terminal(shown)) as server,
    ):
        yield server


def values(camera):
    return {each.name: each.value for each in camera.features() if camera.offered(each).access.writable}


def test_every_parameter_is_refused_and_described_as_read_only(server, camera):
    before = values(camera)
    with closing(ParameterProbe("/shown")) as parameters:
        names = parameters.names()
        assert {"use_sim_time", "frame_id", "Gain"} <= set(names)
        now = dict(zip(names, parameters.values(*names), strict=True))
        requests = [
            Parameter(name=name, value=OTHER[value.type](value))
            for name, value in now.items()
            if value.type in OTHER
        ]
        assert len(requests) > 50
        for kind, service, of in (
            (SetParameters, "set_parameters", lambda answer: answer.results),
            (SetParametersAtomically, "set_parameters_atomically", lambda answer: [answer.result]),
        ):
            for request in requests:
                (result,) = of(parameters.call(kind, f"/shown/{service}", parameters=[request]))
                assert not result.successful, f"{request.name} was set by {service}"
        assert {each.name for each in parameters.describe(*names) if not each.read_only} == set()
        assert dict(zip(names, parameters.values(*names), strict=True))["use_sim_time"] == now["use_sim_time"]
        images = parameters.subscribe(Image, "/shown/image_raw")
        stamp = images.get(timeout=PATIENCE).header.stamp
        assert stamp.sec > 1_700_000_000, "a stamp of a clock that a stranger stopped"
    assert values(camera) == before


def test_every_service_is_a_reading_one_or_refuses_and_there_is_no_topic_to_write_to(server, camera):
    before = values(camera)
    with closing(Probe()) as probe:
        node = ("shown", "/")
        until(lambda: node in probe.node.get_node_names_and_namespaces())
        until(
            lambda: (
                len(probe.node.get_service_names_and_types_by_node(*node)) >= len(READING | SETTING.keys())
            )
        )
        found = {name.rpartition("/")[2] for name, _ in probe.node.get_service_names_and_types_by_node(*node)}
        assert found == READING | SETTING.keys(), "a new service: decide above whether it only reads"
        assert not probe.node.get_subscriber_names_and_types_by_node(*node)
        for service, requests in SETTING.items():
            for kind, request in requests:
                answer = probe.call(kind, f"/shown/{service}", **request)
                assert not answer.success, f"{service} {request}"
    assert values(camera) == before and camera.streaming
