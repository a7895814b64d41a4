"""A camera served on ROS 2, in a domain of its own, and what looks at it."""

import os

import pytest

from grabbergui import sources
from ros2_domain import own_domain
from ros2_patience import be_patient


@pytest.fixture(autouse=True, scope="session")
def domain():
    """Kept to the end: nodes of `grabbergui list` stay until the process ends."""
    os.environ.update(own_domain())


@pytest.fixture(autouse=True)
def ros_home(monkeypatch, tmp_path):
    """Nobody's calibrations but the test's."""
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "ros"))
    return tmp_path / "ros"


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    """Others may have the machine's cores."""
    be_patient(monkeypatch)


@pytest.fixture
def impatience(monkeypatch, patience):
    """For what is not there."""
    monkeypatch.setattr("grabbergui.net.ros2.client.DISCOVERY_TIMEOUT", 1.0)
    monkeypatch.setattr("grabbergui.net.ros2.client_link.SERVICE_TIMEOUT", 1.0)
    monkeypatch.setattr("grabbergui.net.ros2.client_link.SETTLED", 1.0)


@pytest.fixture
def serve(camera, domain):
    """Serves the camera, again and again if need be, and ends what is left."""
    from grabbergui.net.ros2.server import Ros2GrabberServer

    servers = []

    def serve(name, **options):
        servers.append(Ros2GrabberServer(camera, name, **options))
        servers[-1].start()
        return servers[-1]

    yield serve
    for server in servers:
        server.stop()


@pytest.fixture
def camera():
    grabber = sources.create("sim:?width=320&height=240&fps=50&pixel_format=BayerRG8")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.fixture
def server(camera, tmp_path):
    from grabbergui.calibration.fitting import FittedCalibration
    from grabbergui.net.ros2.server import Ros2GrabberServer

    calibration = FittedCalibration(camera, tmp_path / "cam.yaml")
    with Ros2GrabberServer(camera, "/cam", calibration=calibration) as server:
        yield server


@pytest.fixture
def probe(domain):
    from ros2_peers import Probe

    probe = Probe()
    yield probe
    probe.close()


@pytest.fixture
def remote(server):
    grabber = sources.create("ros2:/cam")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.fixture
def drive(domain):
    """Makes drivers of somebody else, and ends them."""
    from other_driver import Driver

    drivers = []

    def drive(*arguments, **options):
        drivers.append(Driver(*arguments, **options))
        return drivers[-1]

    yield drive
    for driver in drivers:
        driver.close()


@pytest.fixture
def driver(drive):
    return drive()


@pytest.fixture
def notices():
    return []


@pytest.fixture
def opened(notices):
    """Opens sources, collects what they notice, and closes them."""
    grabbers = []

    def opened(uri):
        grabber = sources.create(uri)
        grabbers.append(grabber)
        grabber.noticed.connect(notices.append)
        grabber.open()
        return grabber

    yield opened
    for grabber in grabbers:
        grabber.close()
