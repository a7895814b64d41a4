"""A USB3 Vision camera that answers late or wrongly, stalls, or is unplugged."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceLostError,
    GrabberError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, ConnectionState
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.u3v import device as simulated_device
from grabbergui.driver.sim.u3v.device import U3vFaults
from grabbergui.driver.sim.u3v.registers import CONTROL_IN, STREAM_IN
from grabbergui.driver.u3v.device import U3vDevice
from grabbergui.driver.u3v.stream_protocol import Leader
from grabbergui.driver.u3v.usb import UsbHandle
from grabbergui.driver.u3v.watcher import Watcher
from patience import PATIENCE, until
from u3v_frames import grab


def test_unanswered_and_pending_commands_are_waited_for(plug_in) -> None:
    _, device = plug_in(U3vFaults(ignore_every=7, pending_every=5))
    device.open(Access.CONTROL)
    for _ in range(20):
        assert device.read(0, 4) == b"\1\0\1\0"


def test_a_dead_control_channel_is_given_up(plug_in) -> None:
    simulated, device = plug_in()
    device.open(Access.CONTROL)
    simulated.faults.ignore_every = 1
    with pytest.raises(AckTimeoutError, match="did not answer READMEM"):
        device.read(0, 4)
    simulated.faults.ignore_every = 0
    assert device.read(0, 4) == b"\1\0\1\0"


def test_halts_that_a_former_host_left_are_cleared(plug_in) -> None:
    simulated, device = plug_in()
    simulated.pipes[CONTROL_IN].set_halt()
    simulated.pipes[STREAM_IN].set_halt()
    camera = DeviceGrabber(device)
    camera.open()
    assert len(grab(camera, 3)) == 3
    camera.close()


def test_a_stream_that_a_former_host_left_on_is_taken_over(plug_in) -> None:
    simulated, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    simulated.registers.stream_enabled = True
    assert len(grab(camera, 3)) == 3
    camera.close()


def test_a_stale_answer_is_dropped(plug_in) -> None:
    simulated, device = plug_in()
    device.open(Access.CONTROL)
    simulated.pipes[CONTROL_IN].put(bytes.fromhex("5533564300000108080016ff0000010000000000"))
    assert device.read(0, 4) == b"\1\0\1\0"


def test_stalls_are_cleared_and_the_stream_goes_on(plug_in) -> None:
    _, device = plug_in(U3vFaults(stall_every=5))
    camera = DeviceGrabber(device)
    camera.open()
    frames = grab(camera, 20)
    statistics = camera.statistics()
    camera.close()
    assert all(frame.complete for frame in frames)
    assert statistics.lost >= 3
    assert statistics.packets_missing >= 3


def test_ids_that_jump_far_ahead_are_no_lost_frames(plug_in, monkeypatch: pytest.MonkeyPatch) -> None:
    made = simulated_device.Leader

    def jumping(block_id: int, *fields: int) -> Leader:
        return made(block_id + (1 << 60) * (block_id // 4) + 3 * (block_id > 1), *fields)

    monkeypatch.setattr(simulated_device, "Leader", jumping)
    _, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    assert len(grab(camera, 12)) == 12
    assert 0 < camera.statistics().lost < 1000
    camera.close()


def test_short_frames_are_counted_or_delivered_as_such(plug_in) -> None:
    _, device = plug_in(U3vFaults(short_every=4))
    device.open(Access.CONTROL)
    frames: list[Frame] = []

    def keep(frame: Frame) -> None:  # and let its buffer be used again
        frames.append(replace(frame, payload=frame.payload.copy()))

    device.open_stream(StreamRequest(64 * 48, deliver_incomplete=True), keep)
    device.write(reg.ACQUISITION_START.address, (1).to_bytes(4, "big"))
    until(lambda: len(frames) >= 12)
    device.close_stream()
    short = [frame for frame in frames if not frame.complete]
    assert short
    assert all(frame.missing_bytes == 64 * 24 for frame in short)
    assert not any(frame.payload[64 * 24 :].any() for frame in short), "an earlier frame shows through"
    assert device.stream_statistics().incomplete == len(short)


def test_frames_that_end_early_are_complete_and_lower(plug_in) -> None:
    _, device = plug_in(U3vFaults(early_every=1), width=256, height=32)
    camera = DeviceGrabber(device)
    camera.open()
    frames = grab(camera, 10)
    camera.close()
    assert all(frame.complete and frame.height == 16 for frame in frames)


def test_unplugging_while_streaming_is_reported_once_and_the_camera_returns(plug_in) -> None:
    simulated, device = plug_in(U3vFaults(unplug_after_frames=10))
    camera = DeviceGrabber(device)
    states: list[ConnectionState] = []
    camera.connection_changed.connect(lambda state, reason: states.append(state))
    camera.open()
    camera.start()
    until(lambda: ConnectionState.LOST in states)
    camera.close()
    assert states.count(ConnectionState.LOST) == 1
    simulated.faults.unplug_after_frames = 0
    simulated.plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    assert len(grab(camera, 3)) == 3
    camera.close()


def test_unplugging_an_idle_camera_is_noticed(plug_in) -> None:
    simulated, device = plug_in()
    reasons: list[str] = []
    device.on_lost = reasons.append
    device.open(Access.CONTROL)
    simulated.unplug()
    until(lambda: bool(reasons))
    with pytest.raises(DeviceLostError, match="unplugged"):
        device.read(0, 4)
    device.close()
    assert len(reasons) == 1


def test_a_transfer_that_unplugging_interrupted_says_so(plug_in, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise TransportError("USB error: Input/Output Error")

    simulated, device = plug_in()
    reasons: list[str] = []
    device.on_lost = reasons.append
    monkeypatch.setattr(Watcher, "_run", lambda watcher: None)
    device.open(Access.CONTROL)
    monkeypatch.setattr(UsbHandle, "write", fail)
    with pytest.raises(TransportError, match="Input/Output"):
        device.write(0, bytes(4))
    assert not reasons, "a disturbance is no loss"
    simulated.unplug()
    with pytest.raises(DeviceLostError, match="unplugged"):
        device.write(0, bytes(4))
    assert len(reasons) == 1
    device.close()


def _everything(device: U3vDevice) -> None:
    """Open, describe, stream a little, stop."""
    device.open(Access.CONTROL)
    device.description()
    got = threading.Event()
    device.open_stream(StreamRequest(64 * 48), lambda frame: got.set())
    device.write(reg.ACQUISITION_START.address, (1).to_bytes(4, "big"))
    assert got.wait(PATIENCE)
    device.write(reg.ACQUISITION_STOP.address, (1).to_bytes(4, "big"))
    device.close_stream()
    device.close()


def test_unplugged_at_every_step_it_fails_clearly_and_opens_again(plug_in) -> None:
    simulated, device = plug_in()
    _everything(device)
    commands = simulated.commands_seen
    assert commands > 40
    for step in range(1, commands + 1):
        simulated.plug_in()
        simulated.faults.unplug_after_commands = step
        try:
            _everything(device)
        except GrabberError as error:
            assert isinstance(error, (DeviceLostError, SourceNotFoundError)), f"step {step}: {error!r}"
        device.close()
        simulated.unplug()
    simulated.faults.unplug_after_commands = 0
    simulated.plug_in()
    _everything(device)


def test_opening_that_fails_at_any_step_leaves_nothing_behind(plug_in) -> None:
    simulated, device = plug_in()
    device.open(Access.CONTROL)
    device.close()
    commands, bus = simulated.commands_seen, device.backend
    threads = set(threading.enumerate())
    for step in range(1, commands):
        simulated.plug_in()
        simulated.faults.unplug_after_commands = step
        with pytest.raises(GrabberError):
            device.open(Access.CONTROL)
        assert bus.opened == 0, f"step {step}"
        assert set(threading.enumerate()) <= threads, f"step {step}"
        simulated.unplug()
    simulated.faults.unplug_after_commands = 0
