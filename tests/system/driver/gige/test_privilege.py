"""Who controls a camera: what a refusal says, and a controller that ended without releasing it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from grabbergui.core.errors import AccessDeniedError
from grabbergui.core.grabber import Access
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.gige import discovery, privilege
from grabbergui.driver.gige.bootstrap import BootstrapRegister, ControlPrivilege
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.device import GigeDevice, discover
from grabbergui.driver.gige.gvcp import WriteReg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import until

ADDRESS = f"127.85.{os.getpid() % 250 + 1}.1"
TAKE = WriteReg(((BootstrapRegister.CCP, ControlPrivilege.CONTROL),))
HOLD = """
import sys
from grabbergui.core.grabber import Access
from grabbergui.driver.gige.device import GigeDevice
device = GigeDevice(sys.argv[1])
device.open(Access.CONTROL)
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def simulated() -> Iterator[GigeCamera]:
    camera = GigeCamera(ADDRESS)
    yield camera
    camera.close()


@pytest.fixture
def holder(simulated: GigeCamera) -> Iterator[subprocess.Popen[str]]:
    """Another program that controls the camera."""
    command = [sys.executable, "-c", HOLD, simulated.address]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None and program.stdout.readline() == "held\n"
        yield program
        program.kill()


def test_another_program_of_this_machine_is_named(holder: subprocess.Popen[str]) -> None:
    pattern = rf"another application at 127\.0\.0\.1 \(.+, PID {holder.pid}\) controls .*; close it there"
    with closing(GigeDevice(ADDRESS)) as device, pytest.raises(AccessDeniedError, match=pattern):
        device.open(Access.CONTROL)


def test_a_controller_that_was_killed_is_waited_for(
    simulated: GigeCamera, holder: subprocess.Popen[str]
) -> None:
    simulated.control.memory.set(gev.HEARTBEAT_TIMEOUT, 1500)
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert simulated.control.controlled
    with closing(GigeDevice(ADDRESS)) as device:
        assert device.open(Access.CONTROL) is Access.CONTROL


def test_an_ended_controller_is_waited_for_no_longer_than_allowed(
    simulated: GigeCamera, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(privilege, "LONGEST_WAIT", 0.2)
    with closing(ControlLink(ADDRESS)) as link:
        link.execute(TAKE)
    simulated.control.memory.set(gev.HEARTBEAT_TIMEOUT, 60_000)
    with (
        closing(GigeDevice(ADDRESS)) as device,
        pytest.raises(AccessDeniedError, match=r"another application at 127\.0\.0\.1 controls"),
    ):
        device.open(Access.CONTROL)


def test_a_controller_on_another_computer_is_not_waited_for(
    simulated: GigeCamera, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(privilege, "_released_in_time", lambda link: pytest.fail("waited"))
    with closing(ControlLink(ADDRESS)) as link, closing(GigeDevice(ADDRESS)) as device:
        link.execute(TAKE)
        simulated.control.memory.set(gev.PRIMARY_IP, 0xC000_0205)
        with pytest.raises(AccessDeniedError, match=r"another application at 192\.0\.2\.5 controls"):
            device.open(Access.CONTROL)


def test_a_holder_that_the_camera_does_not_report_is_another_application(simulated: GigeCamera) -> None:
    with closing(ControlLink(ADDRESS)) as link, closing(GigeDevice(ADDRESS)) as device:
        link.execute(TAKE)
        simulated.control.memory.set(gev.PRIMARY_IP, 0)
        with pytest.raises(AccessDeniedError, match="another application controls"):
            device.open(Access.CONTROL)


@pytest.fixture
def found(simulated: GigeCamera, monkeypatch: pytest.MonkeyPatch) -> Callable[[], DeviceInfo]:
    """Searches for the camera, and for no other."""
    privilege._kept_controller.cache_clear()
    monkeypatch.setattr(discovery, "discover", lambda timeout: [discovery.ask(ADDRESS, timeout)])
    return lambda: discover(2.0)[0]


def test_a_search_names_the_program_that_controls_a_camera(
    found: Callable[[], DeviceInfo], holder: subprocess.Popen[str]
) -> None:
    """That a camera was in use was known only once connecting had failed."""
    pattern = rf"in use by .+, PID {holder.pid}"
    assert re.fullmatch(pattern, found().note)


def test_a_search_names_a_controller_on_another_computer_by_its_address(
    found: Callable[[], DeviceInfo], simulated: GigeCamera, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(ControlLink(ADDRESS)) as link:
        link.execute(TAKE)
        monkeypatch.setattr(privilege, "ip_text", lambda _: "192.0.2.7")
        assert found().note == "in use by a program at 192.0.2.7"
        link.execute(WriteReg(((BootstrapRegister.CCP, ControlPrivilege.EXCLUSIVE),)))
        assert found().note == "in use by another program"


def test_a_camera_of_this_program_is_not_in_use_by_another(
    found: Callable[[], DeviceInfo], simulated: GigeCamera
) -> None:
    with closing(GigeDevice(ADDRESS)) as device:
        device.open(Access.CONTROL)
        assert not found().note


def test_a_camera_that_this_program_controls_is_refused(simulated: GigeCamera) -> None:
    with closing(GigeDevice(ADDRESS)) as first, closing(GigeDevice(ADDRESS)) as second:
        first.open(Access.CONTROL)
        with pytest.raises(AccessDeniedError, match=r"this program controls .* already; close it first"):
            second.open(Access.CONTROL)


@pytest.mark.parametrize("access", [Access.CONTROL, Access.MONITOR])
def test_exclusive_control_refuses_reading_too(simulated: GigeCamera, access: Access) -> None:
    with closing(ControlLink(ADDRESS)) as link, closing(GigeDevice(ADDRESS)) as device:
        link.execute(WriteReg(((BootstrapRegister.CCP, ControlPrivilege.EXCLUSIVE),)))
        with pytest.raises(
            AccessDeniedError, match=r"another application has exclusive control .*; close it"
        ):
            device.open(access)


def test_a_reader_is_told_who_has_control_at_first_and_when_that_changes(simulated: GigeCamera) -> None:
    reported: list[bool] = []
    with closing(GigeDevice(ADDRESS)) as device, closing(GigeDevice(ADDRESS)) as controller:
        device.on_held = controller.on_held = reported.append
        controller.open(Access.CONTROL)
        device.open(Access.MONITOR)
        until(lambda: reported == [True])
        controller.close()
        until(lambda: reported == [True, False])
        controller.open(Access.CONTROL)
        until(lambda: reported == [True, False, True])
