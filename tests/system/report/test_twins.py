"""A report of every kind of source makes a twin with the same features."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from grabbergui import sources
from grabbergui.cli import features as features_command
from grabbergui.core.errors import (
    AckTimeoutError,
    DeviceStatusError,
    GrabberError,
    SourceUnavailableError,
    UsageError,
)
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.twin import report_file
from grabbergui.driver.twin.device import device_of
from grabbergui.driver.twin.recorded_device import MOST_SILENCES
from grabbergui.driver.twin.report_file import CameraReport
from patience import PATIENCE

ADDRESS = f"127.83.{os.getpid() % 250 + 1}.1"
SMALL = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 100.0, reg.EXPOSURE_TIME: 1000.0}
LIVING = {"DeviceTemperature", "Timestamp"}
"""Features of the simulated camera that differ from one moment to the next."""

ReportOf = Callable[..., CameraReport]


def rows(grabber: FrameGrabber) -> list[dict[str, object]]:
    """Return what `features --json` prints, without values that live."""
    with closing(grabber):
        grabber.open(Access.CONTROL)
        found = [features_command._as_dict(feature) for feature in grabber.features()]
    return [row for row in found if row["name"] not in LIVING]


def twin(report: CameraReport) -> DeviceGrabber:
    return DeviceGrabber(device_of(report, "twin:file.zip", answer_times=False))


@pytest.fixture
def on_the_wire() -> Iterator[GigeCamera]:
    with closing(GigeCamera(ADDRESS, power_on=SMALL)) as camera:
        yield camera


def simulated() -> FrameGrabber:
    return sources.create("sim:?width=64&height=48&fps=100")


def test_of_the_simulated_camera(report_of: ReportOf) -> None:
    report = report_of(simulated())
    assert not report.problems and len(report.stream.frames) == 5
    assert rows(twin(report)) == rows(simulated())


def test_of_a_camera_on_the_network(report_of: ReportOf, on_the_wire: GigeCamera) -> None:
    report = report_of(sources.create(f"gige:{ADDRESS}"))
    assert not report.problems
    assert rows(twin(report)) == rows(sources.create(f"gige:{ADDRESS}"))
    known = {each.name: each.data for each in report.bootstrap}
    assert known["GVCP_CAPABILITY"] == on_the_wire.control.memory.read(0x934, 4)
    tests = {test.size: test.arrived for test in report.stream.packet_tests}
    assert tests[1500] and tests[576]
    assert on_the_wire.control.memory.read(0xD00, 4) == bytes(4), "the channel is closed again"


def test_of_a_camera_on_the_usb(report_of: ReportOf) -> None:
    """On the bus of the tests, within this process."""
    from grabbergui.driver.sim.u3v.backend import SimulatedBus
    from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
    from grabbergui.driver.u3v.device import U3vDevice

    camera = SimulatedU3vDevice(CameraModel(power_on=SMALL))
    bus = SimulatedBus(camera)
    camera.start()
    try:
        report = report_of(DeviceGrabber(U3vDevice(backend=bus)))
        assert not report.problems and len(report.stream.frames) == 5
        known = {each.name: each for each in report.bootstrap}
        assert known["ABRM.SERIAL_NUMBER"].data == b"SIM001".ljust(64, b"\0")
        assert known["SIRM.REQUIRED_PAYLOAD_SIZE"].length == 8 and not any(x.failure for x in known.values())
        assert rows(twin(report)) == rows(DeviceGrabber(U3vDevice(backend=bus)))
    finally:
        camera.stop()


def test_of_a_gentl_producers_camera(report_of: ReportOf) -> None:
    genicam = pytest.importorskip("genicam")
    producer = Path(genicam.__file__).parent / "viky.cti"
    if not producer.is_file():
        pytest.skip("this build of genicam ships no viky.cti")
    report = report_of(sources.create(f"gentl:{producer}"))
    assert not report.problems and len(report.stream.frames) == 5
    assert rows(twin(report)) == rows(sources.create(f"gentl:{producer}"))


def test_of_a_webcam(report_of: ReportOf, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the video device of the tests."""
    pytest.importorskip("linuxpy.video.device", reason="linuxpy has Linux's video interface")
    from fake_video import FakeVideo
    from grabbergui.driver.v4l2 import device

    info = DeviceInfo("v4l2:/dev/video7", "Acme", "Eye", "7", "V4L2", "/dev/video7")
    monkeypatch.setattr(device, "find", lambda: [info])

    def webcam() -> DeviceGrabber:
        return DeviceGrabber(device.V4l2Device("", DeviceInfo("v4l2:"), lambda path: FakeVideo()))  # type: ignore[arg-type, return-value]

    report = report_of(webcam(), frames=0)
    assert not report.problems
    assert rows(twin(report)) == rows(webcam())


@pytest.mark.aravis
def test_of_a_camera_by_aravis(report_of: ReportOf, on_the_wire: GigeCamera) -> None:
    try:
        report = report_of(sources.create(f"aravis:{ADDRESS}"))
    except SourceUnavailableError as missing:
        pytest.skip(str(missing))
    assert not report.problems and len(report.stream.frames) == 5
    assert rows(twin(report)) == rows(sources.create(f"aravis:{ADDRESS}"))


def test_of_a_recording_has_features_and_frames_but_makes_no_twin(
    quick: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from grabbergui.cli import main

    recording, file = tmp_path / "run", tmp_path / "report.zip"
    assert main(["record", "sim:?width=64&height=48&fps=100", "-n", "5", "--out", str(recording)]) == 0
    assert main(["report", f"file:{recording}", "--out", str(file), "--frames", "3"]) == 0
    report = report_file.load(file)
    assert report.features and len(report.stream.frames) == 3 and not report.registers
    with pytest.raises(UsageError, match=r"has no registers.*file: sources have none"):
        sources.create(f"twin:{file}")


def test_frames_come_as_they_were_recorded(report_of: ReportOf) -> None:
    report = report_of(simulated(), frames=20)
    with closing(twin(report)) as camera:
        camera.open()
        camera.write_feature("Width", 32)
        queue = camera.open_queue(500)  # on a busy machine none may be dropped
        camera.start()
        frames = [queue.get(PATIENCE) for _ in range(10)]
        assert {(frame.width, frame.height, frame.nbytes) for frame in frames} == {(32, 48, 32 * 48)}
        assert [frame.frame_id for frame in frames] == list(range(1, 11))
        period = (frames[-1].received_ns - frames[0].received_ns) / 9e9
        assert period > 0.005, "the original sends one each 10 ms"
        camera.stop()


def test_recorded_pixels_are_shown_again(report_of: ReportOf) -> None:
    report = report_of(simulated(), frames=3, pixels=True)
    with closing(twin(report)) as camera:
        camera.open()
        queue = camera.open_queue(1)
        camera.start()
        assert queue.get(PATIENCE).payload.tobytes() in report.pixels


class Refusing(type(sources.create("sim:").device)):  # type: ignore[misc]
    """A simulated camera that refuses one register, and counts what is read."""

    refused = 0x100404  # the gain

    def read(self, address: int, length: int) -> bytes:
        self.seen.append((address, length))
        if address == self.refused:
            raise DeviceStatusError("the camera is busy with itself", 0x8007)
        return super().read(address, length)  # type: ignore[no-any-return]


def refusing() -> DeviceGrabber:
    camera = simulated()
    assert isinstance(camera, DeviceGrabber)
    camera.device.__class__ = Refusing
    camera.device.seen = []  # type: ignore[attr-defined]
    return camera


def test_a_refusal_is_the_twins_too(report_of: ReportOf) -> None:
    report = report_of(refusing())
    copy = twin(report)
    assert rows(copy) == rows(refusing())
    with closing(copy):
        copy.open()
        assert "busy with itself" in copy.feature("Gain").problem
        with pytest.raises(DeviceStatusError) as error:
            copy.device.read(0x100404, 4)
        assert error.value.status == 0x8007


def test_no_register_is_read_twice_before_the_stream(report_of: ReportOf) -> None:
    camera = refusing()
    report = report_of(camera, frames=0)
    seen = camera.device.seen  # type: ignore[attr-defined]
    assert len(seen) == len(set(seen)) == len(report.registers)


def test_selectors_and_commands_are_left_alone(report_of: ReportOf, monkeypatch: pytest.MonkeyPatch) -> None:
    camera = simulated()
    assert isinstance(camera, DeviceGrabber)
    writes: list[int] = []
    write = camera.device.write
    monkeypatch.setattr(
        camera.device, "write", lambda address, data: (writes.append(address), write(address, data))
    )
    report_of(camera, frames=0)
    assert writes == []
    report = report_of(camera)
    names = [next(each.name for each in reg.ALL if each.address == address) for address in writes]
    assert names == ["TLParamsLocked", "AcquisitionStart", "AcquisitionStop", "TLParamsLocked"]
    assert [each.address for each in report.stream.accesses if each.written] == writes


def test_a_camera_that_falls_silent_is_not_asked_for_hours(report_of: ReportOf) -> None:
    camera = refusing()
    device = camera.device

    def silent(address: int, length: int) -> bytes:
        device.seen.append((address, length))  # type: ignore[attr-defined]
        raise AckTimeoutError("no answer within 1 s")

    reads = 0

    def read(address: int, length: int) -> bytes:
        nonlocal reads
        reads += 1
        return original(address, length) if reads < 60 else silent(address, length)

    original = device.read
    device.read = read  # type: ignore[method-assign]
    report = report_of(camera)
    assert reads < 60 + 2 * MOST_SILENCES
    assert any("did not answer" in problem for problem in report.problems)
    assert len(report.registers) > 40


@pytest.mark.parametrize("broken", ["description", "registers", "all"])
def test_a_camera_that_opens_only_half_is_reported_as_far(
    report_of: ReportOf, on_the_wire: GigeCamera, monkeypatch: pytest.MonkeyPatch, broken: str
) -> None:
    memory = on_the_wire.control.memory
    if broken == "description":
        memory._blocks = [(start, b"no XML".ljust(len(content))) for start, content in memory._blocks]
    elif broken == "registers":
        monkeypatch.setattr(on_the_wire.model, "read", _fail)
    else:
        on_the_wire.close()
    report = report_of(sources.create(f"gige:{ADDRESS}"))
    if broken == "description":
        assert len(report.bootstrap) > 40 and "no GenICam XML" in report.problems[0]
        copy = twin(report)
        with pytest.raises(GrabberError, match="no GenICam XML"):
            copy.open()
    elif broken == "registers":
        assert report.registers and all(each.failure for each in report.registers if each.address >= 0x100000)
    else:
        assert not report.registers and "no GigE Vision camera answers" in report.problems[0]


def _fail(address: int, length: int) -> bytes:
    from grabbergui.driver.sim.memory import Refusal, RegisterRefusedError

    raise RegisterRefusedError(Refusal.ACCESS_DENIED, "no")
