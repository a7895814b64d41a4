"""Twins as GigE Vision devices: what other programs see of the original, they see of the twin."""

from __future__ import annotations

import os
import random
import re
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace

import pytest

from grabbergui import sources
from grabbergui.cli import features as features_command
from grabbergui.core.errors import AckTimeoutError, DeviceStatusError
from grabbergui.core.grabber import Access
from grabbergui.driver.gige.bootstrap import GvcpCapability, StreamChannel
from grabbergui.driver.gige.discovery import ask
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.twin import report_file
from grabbergui.driver.twin.gige import TwinGigeCamera
from grabbergui.driver.twin.report_file import CameraReport, PacketTest, RecordedAccess
from grabbergui.report import collect, computer
from grabbergui.report.collect import ReportOptions
from patience import PATIENCE, PROGRAM

_OWN = os.getpid() % 250 + 1
ORIGINAL, TWIN = f"127.84.{_OWN}.1", f"127.84.{_OWN}.2"
SMALL = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 100.0, reg.EXPOSURE_TIME: 1000.0}
LIVING = {"DeviceTemperature", "Timestamp", "GevCurrentIPAddress"}


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computer, "network", lambda: {"interfaces": [], "discovery": []})
    monkeypatch.setattr(computer, "findings", list)


def report_on(address: str, frames: int = 0) -> CameraReport:
    report = collect.report_on(f"gige:{address}", ReportOptions(frames), lambda step: None)
    assert not report.problems
    return report_file.decode(report_file.encode(report))


@contextmanager
def pair(deviations: Deviations | None = None) -> Iterator[CameraReport]:
    """An original and its twin, at their addresses."""
    with closing(GigeCamera(ORIGINAL, power_on=SMALL, deviations=deviations)):
        report = report_on(ORIGINAL, frames=3)
        with closing(TwinGigeCamera(TWIN, report)):
            yield report


def rows(address: str) -> list[dict[str, object]]:
    with closing(sources.create(f"gige:{address}")) as camera:
        camera.open(Access.CONTROL)
        found = [features_command._as_dict(feature) for feature in camera.features()]
    return [row for row in found if row["name"] not in LIVING]


DEVIATIONS = {
    "little-endian": Deviations(little_endian=True),
    "schema 1.0": Deviations(little_endian=True, schema=0),
    "falsely declared": Deviations(little_endian=True, declared_big_endian=True),
    "no WRITEMEM": Deviations(absent=GvcpCapability.WRITEMEM | GvcpCapability.PACKETRESEND),
    "refusals": Deviations(refused={reg.GAIN_RAW.address: 0x8006, 0x0400: 0x8003}),
    "short accesses": Deviations(longest_access=256),
    "a packet size that stays": Deviations(read_only=frozenset({StreamChannel(0).packet_size})),
    "damaged archive": Deviations(damaged_archive=True),
}


@pytest.mark.parametrize("deviations", DEVIATIONS.values(), ids=DEVIATIONS.keys())
def test_an_odd_cameras_twin_is_as_odd(deviations: Deviations) -> None:
    with pair(deviations):
        assert rows(TWIN) == rows(ORIGINAL)
        one, other = ask(ORIGINAL, PATIENCE), ask(TWIN, PATIENCE)
        assert one is not None and other is not None
        assert replace(other.identity, ip=one.identity.ip) == one.identity
        for address in (ORIGINAL, TWIN):
            with closing(sources.create(f"gige:{address}")) as camera:
                camera.open(Access.CONTROL)
                camera.write_feature("Width", 32)
                assert camera.feature("Width").value == 32
                queue = camera.open_queue(5)
                camera.start()
                assert queue.get(PATIENCE).raw().shape == (48, 32)


@pytest.mark.aravis
def test_aravis_prints_the_same_values_of_a_twin_as_of_its_original() -> None:
    tool = shutil.which("arv-tool-0.8")
    if tool is None:
        pytest.skip("arv-tool-0.8 is not installed (Debian: aravis-tools-cli)")
    with pair() as report:
        printed = []
        for address in (ORIGINAL, TWIN):
            run = subprocess.run(
                [tool, "-a", address, "values"], capture_output=True, text=True, timeout=PROGRAM, check=True
            )
            living = re.compile(rf".*'({'|'.join(LIVING)})' = .*\n")
            printed.append(living.sub("", run.stdout))
        assert printed[1] == printed[0]
        assert printed[0].count(" = ") > 0.6 * len(report.features)


def test_what_the_original_did_not_answer_is_not_answered() -> None:
    with closing(GigeCamera(ORIGINAL, power_on=SMALL)):
        report = report_on(ORIGINAL)
    silent = RecordedAccess(reg.GAMMA.address, 8, None, 1000.0, "AckTimeoutError", message="no answer")
    registers = (*(each for each in report.registers if each.address != reg.GAMMA.address), silent)
    with (
        closing(TwinGigeCamera(TWIN, replace(report, registers=registers))),
        closing(sources.create(f"gige:{TWIN}")) as camera,
    ):
        camera.open(Access.CONTROL)
        assert camera.feature("Gamma").problem
        assert camera.feature("Width").value == 64
        with pytest.raises((AckTimeoutError, DeviceStatusError)):
            camera.device.read(reg.GAMMA.address, 8)  # type: ignore[attr-defined]


def test_larger_test_packets_than_those_that_arrived_do_not_leave() -> None:
    with closing(GigeCamera(ORIGINAL, power_on=SMALL)):
        report = report_on(ORIGINAL)
    tests = (PacketTest(9000, False), PacketTest(1500, True))
    stream = replace(report.stream, packet_tests=tests)
    with closing(TwinGigeCamera(TWIN, replace(report, stream=stream))):
        again = report_on(TWIN, frames=1)
    assert {test.size for test in again.stream.packet_tests if test.arrived} == {1500, 1400, 576}


def test_a_twin_of_another_transport_is_a_camera_on_the_network() -> None:
    report = collect.report_on("sim:?width=64&height=48&fps=50", ReportOptions(2), lambda step: None)
    with closing(TwinGigeCamera(TWIN, report)):
        found = ask(TWIN, PATIENCE)
        assert found is not None and (found.identity.serial, found.identity.model) == (
            "SIM001",
            "Simulated camera",
        )
        with closing(sources.create(f"gige:{TWIN}")) as camera:
            camera.open(Access.CONTROL)
            queue = camera.open_queue(5)
            camera.start()
            assert queue.get(PATIENCE).width == 64


def test_datagrams_of_any_content_leave_it_answering() -> None:
    report = collect.report_on("sim:?width=64&height=48", ReportOptions(0), lambda step: None)
    chance = random.Random(40)
    with closing(TwinGigeCamera(TWIN, report)), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for code in (0x80, 0x82, 0x84, 0x86, 0x02, 0x04, 0x40, 0x100):
            for length in (0, 1, 4, 7, 8, 12, 16):
                body = chance.randbytes(length)
                head = bytes([0x42, 1]) + code.to_bytes(2, "big") + length.to_bytes(2, "big") + b"\0\7"
                sender.sendto(head + body, (TWIN, 3956))
        assert ask(TWIN, PATIENCE) is not None


def test_two_addresses_get_two_cameras(tmp_path, capsys) -> None:
    import threading

    from grabbergui.driver.twin.gige import serve

    report = collect.report_on("sim:?width=64&height=48", ReportOptions(0), lambda step: None)
    stop, said = threading.Event(), []

    def ready(line: str) -> None:
        said.append(line)
        if len(said) == 2:
            macs = {ask(address, PATIENCE).identity.mac for address in (ORIGINAL, TWIN)}  # type: ignore[union-attr]
            assert len(macs) == 2
            stop.set()

    serve((ORIGINAL, TWIN), report, stop=stop, ready=ready)
    assert [line.rsplit(" ", 1)[1] for line in said] == [ORIGINAL, TWIN]
