"""Vendors' descriptions as twins: opened, every writable feature written at both ends, ten frames.

With GRABBERGUI_ALL_TWINS=1 of all descriptions, over registers of zeros, ones and noise, too, and with some
refused: a hundred twins. Otherwise of six makers' one each.
"""

from __future__ import annotations

import json
import os
import random
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from grabbergui.cli import features as features_command
from grabbergui.core.errors import FeatureError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue
from grabbergui.driver.acquisition import NOT_SETTINGS
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.twin import report_file
from grabbergui.driver.twin.device import device_of
from grabbergui.driver.twin.report_file import CameraReport
from grabbergui.report import collect, computer
from grabbergui.report.collect import ReportOptions
from patience import PATIENCE
from vendors_cameras import VendorsCamera, made_plausible

FOLDER = Path(
    os.environ.get("GRABBERGUI_GENICAM_XML", Path(__file__).parents[4].parent / "shared" / "genicam-xml")
)
DESCRIPTIONS = sorted(FOLDER.glob("*.xml"))
NONE = [pytest.param(None, "", marks=pytest.mark.skip("no vendors' XML here; set GRABBERGUI_GENICAM_XML"))]
ALL = os.environ.get("GRABBERGUI_ALL_TWINS", "") not in ("", "0")


def noise(address: int) -> int:
    return random.Random(address).randrange(256)


KINDS: dict[str, Callable[[bytes], VendorsCamera]] = {
    "plausible": lambda xml: made_plausible(VendorsCamera(xml)),
    "zeros": VendorsCamera,
    "ones": lambda xml: VendorsCamera(xml, lambda address: 0xFF),
    "noise": lambda xml: VendorsCamera(xml, noise),
    **{f"refusing {seed}": lambda xml, seed=seed: refusing(xml, seed) for seed in range(1, 6)},  # type: ignore[misc]
}


def refusing(xml: bytes, seed: int) -> VendorsCamera:
    device = made_plausible(VendorsCamera(xml))
    device.refusing = seed
    return device


FEW = ("Basler_acA1600_20gm", "Daheng_MER2_160_75GC", "Huaray_DS5131", "Imperx", "JAI_RM-6740GE", "PGR_Flea3")
CASES = [
    (path, kind)
    for path in DESCRIPTIONS
    for kind in KINDS
    if ALL or (kind == "plausible" and path.stem in FEW) or (path.stem, kind) == ("PGR_Flea3", "ones")
] or NONE


@pytest.fixture
def report_of(monkeypatch: pytest.MonkeyPatch) -> Callable[[DeviceGrabber], CameraReport]:
    monkeypatch.setattr(computer, "network", lambda: {"interfaces": [], "discovery": []})
    monkeypatch.setattr(computer, "findings", list)

    def make(camera: DeviceGrabber) -> CameraReport:
        report = collect.report_of(camera, ReportOptions(5, seconds=2), lambda step: None)
        return report_file.decode(report_file.encode(report))

    return make


def twin(report: CameraReport) -> DeviceGrabber:
    return DeviceGrabber(device_of(report, "twin:file.zip", answer_times=False))


def printed(feature: Feature) -> str:
    """Return what `features --json` prints; as text, since NaN does not equal itself."""
    return json.dumps(features_command._as_dict(feature))


def ends(feature: Feature) -> Iterator[FeatureValue]:
    """Yield the smallest and the largest value, the first and the last entry, a short and a long text."""
    if feature.kind is FeatureKind.ENUMERATION:
        names = [entry.name for entry in feature.entries if entry.available]
        yield from (names[0], names[-1]) if names else ()
    elif feature.kind is FeatureKind.BOOLEAN:
        yield from (True, False)
    elif feature.kind is FeatureKind.STRING:
        yield from ("", "x" * min((feature.maximum_length or 16) - 1, 255))
    elif feature.kind is not FeatureKind.COMMAND:
        for limit in (feature.minimum, feature.maximum):
            if limit is not None:
                yield limit


@pytest.mark.parametrize(("path", "kind"), CASES, ids=lambda value: getattr(value, "stem", value))
def test_a_twin_is_like_its_original_and_can_be_used(
    report_of: Callable[[DeviceGrabber], CameraReport], path: Path, kind: str
) -> None:
    original = KINDS[kind](path.read_bytes())
    report = report_of(DeviceGrabber(original))
    assert len(report.registers) > 20 and report.features
    with closing(DeviceGrabber(KINDS[kind](path.read_bytes()))) as camera, closing(twin(report)) as copy:
        camera.open()
        copy.open()
        for one, other in zip(camera.features(), copy.features(), strict=True):
            assert printed(other) == printed(one)
        written = taken = 0
        for description in copy.feature_tree().descriptions():
            name = description.name
            if name in NOT_SETTINGS or not copy.feature(name).access.writable:
                continue
            for value in ends(copy.feature(name)):
                written += 1
                try:
                    taken += copy.write_feature(name, value).value == value
                except FeatureError:
                    continue  # by the rules of the description, or a refusal
        assert taken >= 0.5 * written or kind in ("ones", "noise"), f"{taken} of {written}"
    if not report.stream.frames:
        return
    with closing(twin(report)) as copy:
        copy.open()
        queue = copy.open_queue(10)
        copy.start()
        ids = []
        for _ in range(10):
            frame = queue.get(PATIENCE)
            assert frame.complete and frame.nbytes
            ids.append(frame.frame_id)
            del frame  # its buffer may be huge, and the stream has few of those
        assert ids == sorted(set(ids))
