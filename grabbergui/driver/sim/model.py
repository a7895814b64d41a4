"""The simulated camera behind its registers, independent of the transport."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import PayloadType
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.automatic_modes import regulate
from grabbergui.driver.sim.contents import complete, first_piece, payload_bytes
from grabbergui.driver.sim.derived_registers import DECIDING, active_chunks, fastest_rate, update_geometry
from grabbergui.driver.sim.enumerations import (
    AcquisitionMode,
    Chunk,
    ComponentSelector,
    EventSelector,
    File,
    PtpStatus,
    TransportLayer,
    TriggerActivation,
    TriggerSource,
)
from grabbergui.driver.sim.file_control import FileControl
from grabbergui.driver.sim.file_store import FileStore, firmware_version
from grabbergui.driver.sim.h264_encoder import H264Encoder
from grabbergui.driver.sim.lines import LINE1, SignalLines
from grabbergui.driver.sim.lookup_table import LookUpTable
from grabbergui.driver.sim.memory import (
    Refusal,
    Register,
    RegisterMemory,
    RegisterRefusedError,
    RegisterValue,
)
from grabbergui.driver.sim.scene import Scene
from grabbergui.driver.sim.sensor import Sensor
from grabbergui.driver.sim.settings import FrameSettings, settings_of
from grabbergui.driver.sim.timing import (
    Sequencer,
    SimulatedClock,
    Thermometer,
    asked_rate,
    resulting_rate,
    timing_of,
)
from grabbergui.driver.sim.user_sets import UserSets


@dataclass(frozen=True)
class FramePlan:
    """A frame that has been exposed, or soon will be, and waits to be rendered."""

    frame_id: int
    "Counts from 1 in each acquisition."
    timestamp_ns: int
    "Start of the exposure on the device's clock."
    settings: FrameSettings
    chunk_values: dict[Chunk, float]
    "Empty while chunk mode is off."
    payload_bytes: int


class CameraModel:
    """Registers that act, and frames that obey them.

    `read` and `write` may be called from any thread; `prepare`, `next_frame` and `render` from one at a time,
    the stream's.
    """

    on_event: Callable[[EventSelector, int, int], None] | None = None
    """Called with event, frame id, timestamp (ns) for events that are on; any thread, without the lock."""
    on_output: Callable[[bool, int], None] | None = None
    """Called with each level at Line2 and its time (ns, monotonic); any thread, without the lock."""
    on_reset: Callable[[], None] | None = None
    """Called after DeviceReset, on the writing thread."""

    def __init__(
        self,
        *,
        scene: Scene | None = None,
        power_on: Mapping[Register, RegisterValue] | None = None,
        clock: SimulatedClock | None = None,
        files: FileStore | None = None,
    ) -> None:
        """Make a camera that has just been switched on.

        `files` are the files of a camera whose power was cut; without them the camera is new. `power_on`
        replaces registers' defaults and becomes the factory's user set; `clock` must advance like real time
        while `next_frame` waits.
        """
        self.sensor = Sensor(scene)
        self._video = H264Encoder()
        self.device_clock = clock or SimulatedClock()
        self._clock = self.device_clock.monotonic
        self._changed = threading.Condition(threading.RLock())
        self._woken = False
        self._pending_events: list[tuple[EventSelector, int, int]] = []
        self._sequencer = Sequencer()
        self._latched: deque[FrameSettings] = deque()
        "Settings as they were when the last frames were taken, oldest first."
        self._thermometers = (
            Thermometer(self._clock(), 16.0, 14.0),
            Thermometer(self._clock(), 12.0, 7.0),
        )
        self.memory = RegisterMemory(reg.ALL)
        for register, value in (power_on or {}).items():
            self.memory.set(register, value)
        self.files = files or FileStore()
        self._file_control = FileControl(self.memory, self.files, LookUpTable(self.memory, self.files))
        self._update_geometry()
        self._lines = SignalLines(self.memory, self._on_line_edge)
        self._user_sets = UserSets(self.memory, self.files)
        self._show_firmware()
        self._install_hooks()

    def read(self, address: int, length: int) -> bytes:
        """Register bytes. Raises RegisterRefusedError."""
        with self._changed:
            return self.memory.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Write registers and apply the consequences. Raises RegisterRefusedError."""
        try:
            with self._changed:
                self.memory.write(address, data)
                self._changed.notify_all()
        finally:
            self._send_events()

    @property
    def streaming(self) -> bool:
        """Whether an acquisition runs."""
        return self._sequencer.running

    def timestamp(self) -> int:
        """Return the device's clock: ns since power-on or reset, or the network's time under PTP."""
        return self.device_clock.now()

    def stop(self) -> None:
        """End the acquisition, as when control is lost."""
        with self._changed:
            self._stop()
            self._changed.notify_all()

    def set_input(self, high: bool, at: int | None = None) -> None:
        """Set the level at the input Line1, now or at a time of the monotonic clock (ns)."""
        with self._changed:
            self._lines.set_input(high, self._clock() if at is None else at)
            self._changed.notify_all()
        self._send_events()

    def trigger_action(self, at: int | None = None) -> bool:
        """Execute an action command, now or at a device time; return whether a trigger listens to Action1."""
        with self._changed:
            moment = self._clock() if at is None else self.device_clock.to_monotonic(at)
            heard = [self._trigger(which, moment) for which in self._listening(TriggerSource.ACTION1)]
            self._changed.notify_all()
        self._send_events()
        return any(heard)

    def prepare(self) -> None:
        """Prepare frames with the present settings, before the acquisition starts."""
        self.sensor.prepare(settings_of(self.memory))

    def next_frame(self, timeout: float) -> FramePlan | None:
        """Wait until an exposure ends, or its image is to be drawn.

        Returns None after `timeout` seconds without, or after `wake`.
        """
        deadline = self._clock() + int(timeout * 1e9)
        ahead = int(self.sensor.scene.ahead * 1e9)
        with self._changed:
            while True:
                now = self._clock()
                exposure = int(self.memory.number(reg.EXPOSURE_TIME) * 1000)
                due = self._sequencer.due(timing_of(self.memory))
                if due is not None and due + exposure - ahead <= now:
                    plan = self._take(now - exposure)
                    break
                if now >= deadline or self._woken:
                    self._woken = False
                    return None
                end = deadline if due is None else min(deadline, due + exposure - ahead)
                self._changed.wait((end - now) * 1e-9)
        if not ahead:
            self._send_events()
        return plan

    def wake(self) -> None:
        """Let `next_frame` return at once, the present call or the next one. Any thread."""
        with self._changed:
            self._woken = True
            self._changed.notify_all()

    def render(self, plan: FramePlan, out: NDArray[np.uint8]) -> int:
        """Write a frame's payload into `out`, run the automatic modes on it, and return its length.

        Returns after the end of the exposure, even if the image was drawn ahead.
        """
        settings = plan.settings
        begin = first_piece(settings, tuple(plan.chunk_values))
        # The automatic modes need an image even if none is sent.
        unsent = settings.payload_type is PayloadType.CHUNK
        image = np.empty(settings.image_bytes, np.uint8) if unsent else out[begin:]
        values = self.sensor.render(settings, plan.frame_id, plan.timestamp_ns, image)
        with self._changed:
            regulate(self.memory, settings, values)
            self._await_end(plan)
        self._send_events()
        little = self.memory.integer(reg.DEVICE_TL_TYPE) == TransportLayer.USB3_VISION
        return complete(
            settings, plan.frame_id, values, plan.chunk_values, out, self._video, little_endian=little
        )

    def _await_end(self, plan: FramePlan) -> None:
        """Wait for the end of an exposure. The caller holds the lock, which is released while waiting."""
        end = self.device_clock.to_monotonic(plan.timestamp_ns) + int(plan.settings.exposure_us * 1000)
        # No longer than it was early, if the device's clock was set meanwhile.
        end = min(end, self._clock() + int(self.sensor.scene.ahead * 1e9))
        while (left := end - self._clock()) > 0 and self.streaming:
            self._changed.wait(left * 1e-9)

    def _take(self, now: int) -> FramePlan | None:
        taken = self._sequencer.take(timing_of(self.memory), now)
        if taken is None:
            return None
        frame_id, start = taken
        self.device_clock.discipline()
        settings, timestamp = self._obeyed_settings(), self.device_clock.to_device(start)
        values = {
            Chunk.FRAME_ID: frame_id,
            Chunk.TIMESTAMP: timestamp,
            Chunk.EXPOSURE_TIME: settings.exposure_us,
            Chunk.GAIN: settings.gain_db,
        }
        chosen = {chunk: values[chunk] for chunk in active_chunks(self.memory)}
        if self._sequencer.finished:
            self._stop()
        self._lines.expose(start, start + int(settings.exposure_us * 1000))
        self._queue_event(EventSelector.FRAME_START, frame_id, timestamp)
        self._queue_event(EventSelector.EXPOSURE_END, frame_id, timestamp + int(settings.exposure_us * 1000))
        return FramePlan(frame_id, timestamp, settings, chosen, self.memory.integer(reg.PAYLOAD_SIZE))

    def _obeyed_settings(self) -> FrameSettings:
        """Return the settings of this exposure: like a real sensor, it latches them some frames ahead."""
        self._latched.append(settings_of(self.memory))
        latency = 0 if any(timing_of(self.memory).triggered) else self.memory.integer(reg.SETTING_LATENCY)
        while len(self._latched) > latency + 1:
            self._latched.popleft()
        return self._latched[0]

    def _install_hooks(self) -> None:
        memory = self.memory
        for register in DECIDING:
            memory.on_check(register, self._check_unlocked(register))
            memory.on_written(register, self._update_geometry)
        memory.on_check(reg.OFFSET_X, self._check_offset(reg.OFFSET_X, reg.WIDTH, reg.WIDTH_MAX))
        memory.on_check(reg.OFFSET_Y, self._check_offset(reg.OFFSET_Y, reg.HEIGHT, reg.HEIGHT_MAX))
        for register, thermometer in zip(reg.DEVICE_TEMPERATURE, self._thermometers, strict=True):
            memory.on_read(register, partial(self._temperature, thermometer))
        memory.on_read(reg.FRAME_RATE, lambda: asked_rate(memory))
        memory.on_read(reg.RESULTING_FRAME_RATE, lambda: resulting_rate(memory))
        memory.on_read(
            reg.LINK_CURRENT_THROUGHPUT,
            lambda: int(resulting_rate(memory) * memory.integer(reg.PAYLOAD_SIZE)),
        )
        memory.on_check(reg.FRAME_RATE, self._check_frame_rate)
        for register, wanted in ((reg.EXPOSURE_TIME, reg.EXPOSURE_AUTO), (reg.GAIN_RAW, reg.GAIN_AUTO)):
            memory.on_check(register, self._check_manual(register, wanted))
        for register in reg.BALANCE_RATIO:
            memory.on_check(register, self._check_manual(register, reg.BALANCE_WHITE_AUTO))
        self._command(reg.ACQUISITION_START, self._start)
        self._command(reg.ACQUISITION_STOP, self._stop)
        for which, register in enumerate(reg.TRIGGER_SOFTWARE):
            self._command(register, partial(self._software_trigger, which))
        memory.on_check(reg.USER_OUTPUT_VALUE, self._set_user_output)
        memory.on_written(reg.LINE_INVERTER[LINE1], lambda: self._lines.update(self._clock()))
        self._command(reg.TIMESTAMP_LATCH, lambda: memory.set(reg.TIMESTAMP_LATCH_VALUE, self.timestamp()))
        self._command(reg.TIMESTAMP_RESET, self._reset_timestamp)
        memory.on_written(reg.PTP_ENABLE, self._follow_ptp)
        self._command(reg.PTP_DATA_SET_LATCH, self._latch_ptp)
        self._command(reg.DEVICE_RESET, self._reset)
        self._command(reg.USER_SET_LOAD, self._load_user_set)
        self._command(reg.USER_SET_SAVE, self._user_sets.save)
        self._command(reg.FILE_OPERATION_EXECUTE, self._file_control.execute)
        self._command(
            reg.TEST_EVENT_GENERATE,
            lambda: self._queue_event(EventSelector.TEST, self._sequencer.frames_taken, self.timestamp()),
        )

    def _command(self, register: Register, execute: Callable[[], object]) -> None:
        def check(value: RegisterValue) -> RegisterValue:
            if value:
                execute()
            return 0

        self.memory.on_check(register, check)

    def _temperature(self, thermometer: Thermometer) -> float:
        return thermometer.read(self._clock())

    def _check_unlocked(self, register: Register) -> Callable[[RegisterValue], None]:
        def check(value: RegisterValue) -> None:
            if self.streaming or self.memory.integer(reg.TL_PARAMS_LOCKED):
                raise RegisterRefusedError(
                    Refusal.ACCESS_DENIED, f"{register.name} is locked while streaming"
                )
            if register is reg.COMPONENT_ENABLE[ComponentSelector.INTENSITY] and not value:
                raise RegisterRefusedError(Refusal.ACCESS_DENIED, "the intensity is always sent")
            limit = {reg.WIDTH: reg.WIDTH_MAX, reg.HEIGHT: reg.HEIGHT_MAX}.get(register)
            if limit is not None and int(value) > self.memory.integer(limit):
                raise RegisterRefusedError(
                    Refusal.INVALID_PARAMETER, f"{register.name} of {value} is too large"
                )

        return check

    def _update_geometry(self) -> None:
        update_geometry(self.memory)
        largest = payload_bytes(settings_of(self.memory), active_chunks(self.memory))
        self.memory.set(reg.PAYLOAD_SIZE, largest)

    def _check_offset(
        self, offset: Register, size: Register, limit: Register
    ) -> Callable[[RegisterValue], None]:
        def check(value: RegisterValue) -> None:
            if int(value) + self.memory.integer(size) > self.memory.integer(limit):
                raise RegisterRefusedError(
                    Refusal.INVALID_PARAMETER, f"{offset.name} of {value} is too large"
                )

        return check

    def _check_frame_rate(self, value: RegisterValue) -> None:
        if float(value) > fastest_rate(self.memory) * (1 + 1e-9):
            raise RegisterRefusedError(Refusal.INVALID_PARAMETER, f"frame rate of {value} Hz is too fast")

    def _check_manual(self, register: Register, automatic: Register) -> Callable[[RegisterValue], None]:
        def check(value: RegisterValue) -> None:
            if self.memory.integer(automatic):
                raise RegisterRefusedError(
                    Refusal.ACCESS_DENIED, f"{register.name} is set by {automatic.name}"
                )

        return check

    def _start(self) -> None:
        if self.streaming:
            return
        mode = self.memory.integer(reg.ACQUISITION_MODE)
        frames = {
            AcquisitionMode.SINGLE_FRAME: 1,
            AcquisitionMode.MULTI_FRAME: self.memory.integer(reg.ACQUISITION_FRAME_COUNT),
        }.get(AcquisitionMode(mode))
        self._sequencer.start(self._clock(), frames)
        self._latched.clear()
        self.memory.set(reg.TL_PARAMS_LOCKED, 1)
        for thermometer in self._thermometers:
            thermometer.set_streaming(True, self._clock())

    def _stop(self) -> None:
        if not self.streaming:
            return
        self._sequencer.stop()
        self.memory.set(reg.TL_PARAMS_LOCKED, 0)
        for thermometer in self._thermometers:
            thermometer.set_streaming(False, self._clock())

    def _listening(self, source: TriggerSource) -> list[int]:
        """Return the indices of the triggers that wait for a source."""
        return [
            which
            for which, register in enumerate(reg.TRIGGER_SOURCE)
            if self.memory.integer(register) == source and self.memory.integer(reg.TRIGGER_MODE[which])
        ]

    def _set_user_output(self, value: RegisterValue) -> None:
        before = self.memory.integer(reg.USER_OUTPUT_VALUE)
        if int(value) == before:
            return
        self._lines.set_user_output(bool(value), self._clock())
        self._trigger_by_edge(TriggerSource.USER_OUTPUT0, bool(value), self._clock())

    def _on_line_edge(self, high: bool, at: int) -> None:
        event = EventSelector.LINE1_RISING_EDGE if high else EventSelector.LINE1_FALLING_EDGE
        self._queue_event(event, self._sequencer.frames_taken, self.device_clock.to_device(at))
        self._trigger_by_edge(TriggerSource.LINE1, high, at)

    def _trigger_by_edge(self, source: TriggerSource, rising: bool, at: int) -> None:
        edge = TriggerActivation.RISING_EDGE if rising else TriggerActivation.FALLING_EDGE
        for which in self._listening(source):
            if self.memory.integer(reg.TRIGGER_ACTIVATION[which]) in (edge, TriggerActivation.ANY_EDGE):
                self._trigger(which, at)

    def _software_trigger(self, which: int) -> None:
        if which not in self._listening(TriggerSource.SOFTWARE):
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "the software trigger is off")
        self._trigger(which, self._clock())

    def _trigger(self, which: int, moment: int) -> bool:
        delay = int(self.memory.number(reg.TRIGGER_DELAY[which]) * 1000)
        taken = self._sequencer.trigger(which, moment + delay)
        if not taken and self.streaming:
            self._queue_event(
                EventSelector.FRAME_TRIGGER_MISSED,
                self._sequencer.frames_taken,
                self.device_clock.to_device(moment),
            )
        return taken

    def _load_user_set(self) -> None:
        if self.streaming:
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "user sets cannot be loaded while streaming")
        self._user_sets.apply(reg.USER_SET_SELECTOR)
        self._update_geometry()
        self._lines.update(self._clock())

    def _follow_ptp(self) -> None:
        on = bool(self.memory.integer(reg.PTP_ENABLE))
        self.device_clock.follow(on)
        self.memory.set(reg.PTP_STATUS, PtpStatus.SLAVE if on else PtpStatus.DISABLED)

    def _latch_ptp(self) -> None:
        self.memory.set(reg.PTP_OFFSET_FROM_MASTER, self.device_clock.offset_from_master())

    def _reset_timestamp(self) -> None:
        if self.device_clock.following:
            raise RegisterRefusedError(Refusal.ACCESS_DENIED, "PTP sets the clock")
        self.device_clock.reset()

    def _reset(self) -> None:
        self._stop()
        self._file_control.close_all()
        self._show_firmware()
        self._user_sets.apply_or_factory(reg.USER_SET_DEFAULT)
        self._update_geometry()
        self._lines.update(self._clock())
        for register in reg.EVENT_NOTIFICATION:
            self.memory.set(register, 0)
        self.memory.set(reg.PTP_ENABLE, 0)
        self._follow_ptp()
        self.device_clock.reset()
        if self.on_reset:
            self.on_reset()

    def _show_firmware(self) -> None:
        """Run the firmware in the file, as every start does."""
        version = firmware_version(self.files.content(File.FIRMWARE))
        self.memory.set(reg.DEVICE_FIRMWARE_VERSION, version or "")

    def _queue_event(self, event: EventSelector, frame_id: int, timestamp: int) -> None:
        if self.memory.integer(reg.EVENT_NOTIFICATION[event]):
            self._pending_events.append((event, frame_id, timestamp))

    def _send_events(self) -> None:
        """Pass queued events to the listener, outside the lock so that it may read registers."""
        while self._pending_events:
            with self._changed:
                events, self._pending_events = self._pending_events, []
            for event in events:
                if self.on_event:
                    self.on_event(*event)
        with self._changed:
            levels = self._lines.take_output()
        for level in levels:
            if self.on_output:
                self.on_output(*level)
