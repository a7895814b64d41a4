"""force-ip and trigger-group on simulated cameras on the wire."""

import json
import os

import pytest

from grabbergui.cli import main
from grabbergui.core.errors import AckTimeoutError, DeviceStatusError, TransportError
from grabbergui.driver.gige import discovery
from grabbergui.driver.gige.address_commands import send_action
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvcp_messages import Action
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.registers import GVCP_CONFIGURATION
from grabbergui.driver.sim.gige.server import GigeCamera

NET = f"127.85.{os.getpid() % 250 + 1}"
"Network of this test run alone: others may run at the same time."
ADDRESSES = (f"{NET}.1", f"{NET}.2")


@pytest.fixture
def cameras():
    started = [GigeCamera(address, power_on={reg.WIDTH: 64, reg.HEIGHT: 48}) for address in ADDRESSES]
    yield started
    for camera in started:
        camera.close()


def test_cameras_on_ptp_expose_at_the_same_moment(cameras, capsys):
    sources = [f"gige:{address}" for address in ADDRESSES]
    command = ["trigger-group", "0x10", *sources, "-n", "2", "--json", "--ahead"]
    # A busy machine hears of it late.
    assert any(main([*command, ahead]) == 0 for ahead in ("0.3", "3", "20"))
    result = json.loads(capsys.readouterr().out)
    assert (result["cameras"], result["actions"], result["clock"]) == (2, 2, "PTP")
    assert len(result["spread_us"]) == 2
    assert result["largest_spread_us"] == max(result["spread_us"]) < 1000


def test_too_late_an_action_says_what_to_do(cameras, capsys):
    assert main(["trigger-group", "1", f"gige:{ADDRESSES[0]}", "--ahead", "0"]) == 1
    assert "use more than --ahead 0" in capsys.readouterr().err


def test_without_ptp_the_action_is_taken_at_once(cameras, capsys):
    assert main(["trigger-group", "1", f"gige:{ADDRESSES[0]}", "--no-ptp"]) == 0
    assert "1 action at 1 camera" in capsys.readouterr().out


def test_a_group_is_of_gige_cameras(capsys):
    assert main(["trigger-group", "1", "sim:"]) == 2
    assert "sim: is not a GigE Vision camera" in capsys.readouterr().err


@pytest.mark.parametrize("key", ["x", "-1", "0x100000000"])
def test_keys_have_32_bits(key, capsys):
    assert main(["trigger-group", key, "sim:"]) == 2
    assert "0xFFFFFFFF" in capsys.readouterr().err or key == "-1"


def test_a_camera_of_another_group_is_named(cameras):
    with pytest.raises(AckTimeoutError, match=ADDRESSES[1]):
        send_action(Action(9, 9, 9), ADDRESSES, timeout=0.2)


def test_an_action_for_where_no_network_leads_says_so():
    with pytest.raises(TransportError, match=r"no way to 255\.255\.255\.255"):
        send_action(Action(9, 9, 9), ["255.255.255.255"])


def test_an_action_of_the_past_is_refused(cameras):
    main(["set", f"gige:{ADDRESSES[0]}", "ActionDeviceKey=7", "ActionGroupKey=7", "ActionGroupMask=1"])
    cameras[0].control.memory.set(GVCP_CONFIGURATION, 8)  # actions count without a controller too
    with pytest.raises(DeviceStatusError) as refusal:
        send_action(Action(7, 7, 1, time=1), ADDRESSES[:1])
    assert refusal.value.status == Status.ACTION_LATE


def test_force_ip_moves_a_camera_wherever_it_is(cameras, capsys):
    mac = discovery.ask(ADDRESSES[1], 2).identity.mac
    assert main(["force-ip", mac, f"{NET}.7", "255.0.0.0"]) == 0
    assert f"gige:{NET}.7" in capsys.readouterr().out
    assert discovery.ask(f"{NET}.7", 2).identity.mac == mac
    assert discovery.ask(ADDRESSES[0], 2).identity.mac != mac


def test_force_ip_says_when_nobody_listens_or_the_address_is_none(capsys):
    assert main(["force-ip", "02:00:00:00:00:01", f"{NET}.9"]) == 1
    assert "02:00:00:00:00:01" in capsys.readouterr().err
    assert main(["force-ip", "02:00", f"{NET}.9"]) == 2
    assert "no MAC address" in capsys.readouterr().err
    assert main(["force-ip", "02:00:00:00:00:01", "somewhere"]) == 2
