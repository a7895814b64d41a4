"""A camera whose description cannot be had or used: it gets one from a file, which is kept for its model."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from grabbergui import sources
from grabbergui.core.errors import GrabberError, MissingFileError, UsageError
from grabbergui.core.grabber import Access
from grabbergui.driver.description import unpack
from grabbergui.driver.description_files import HINT
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.camera_xml import zipped
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.deviations import Deviations
from grabbergui.driver.sim.gige.server import GigeCamera

WEB = ("http://www.example.com/cameras/model.xml", "")
_numbers = itertools.count(1)


@pytest.fixture(autouse=True)
def own_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture
def stage() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def served(stage: ExitStack, deviations: Deviations) -> str:
    address = f"127.14.{os.getpid() % 250 + 1}.{next(_numbers)}"
    stage.enter_context(closing(GigeCamera(address, power_on={reg.WIDTH: 320}, deviations=deviations)))
    return f"gige:{address}"


def width(uri: str) -> object:
    with closing(sources.create(uri)) as grabber:
        grabber.open(Access.MONITOR)
        return grabber.feature("Width").value


@pytest.mark.parametrize("name", ["model.xml", "model.zip"])
def test_a_file_stands_in_and_is_kept_for_the_model(
    stage: ExitStack, tmp_path: Path, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    uri = served(stage, Deviations(urls=WEB))
    with pytest.raises(GrabberError, match="only Local: and File: can be read") as refused:
        width(uri)
    assert HINT in str(refused.value)
    file = tmp_path / name
    file.write_bytes(gev.description() if name.endswith("xml") else zipped("a.xml", gev.description()))
    assert width(f"{uri}?description={file}") == 320
    file.unlink()
    assert width(uri) == 320 and "which was given before" in caplog.text
    assert width(served(stage, Deviations(urls=WEB))) == 320, "another camera of that model"


def test_a_broken_description_is_replaced_too(stage: ExitStack, tmp_path: Path) -> None:
    memory = f"Local:a.xml;{gev.XML_ADDRESS:x};40"
    uri = served(stage, Deviations(urls=(memory, "")))  # 64 bytes of an archive
    with pytest.raises(GrabberError, match="description"):
        width(uri)
    file = tmp_path / "a.xml"
    file.write_bytes(gev.description())
    assert width(f"{uri}?description={file}") == 320 == width(uri)


def test_its_own_description_comes_before_a_kept_one(stage: ExitStack, tmp_path: Path) -> None:
    uri = served(stage, Deviations())
    file = tmp_path / "other.xml"
    file.write_bytes(gev.description().replace(b'"Width"', b'"Breadth"').replace(b">Width<", b">Breadth<"))
    with closing(sources.create(f"{uri}?description={file}")) as grabber:
        grabber.open(Access.MONITOR)
        assert grabber.has_feature("Breadth") and not grabber.has_feature("Width")
    assert width(uri) == 320


@pytest.mark.parametrize(
    ("content", "error"),
    [(None, MissingFileError), (b"PK\3\4 broken", UsageError), (b"<no description>", GrabberError)],
)
def test_a_file_that_is_none_is_refused_and_not_kept(
    stage: ExitStack, tmp_path: Path, content: bytes | None, error: type[Exception]
) -> None:
    uri = served(stage, Deviations())
    file = tmp_path / "a.xml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(error):
        width(f"{uri}?description={file}")
    assert not list((tmp_path / "data").rglob("*.xml"))


def test_an_archive_with_a_wrong_checksum_is_used(stage: ExitStack, caplog: pytest.LogCaptureFixture) -> None:
    """harvesters 85 and 110."""
    assert width(served(stage, Deviations(damaged_archive=True))) == 320
    assert "wrong checksum" in caplog.text


def test_a_damaged_archive_is_not() -> None:
    archive = Deviations(damaged_archive=True).store(zipped("a.xml", b"<Register" * 50))
    with pytest.raises(GrabberError, match="damaged: Bad CRC-32"):
        unpack(archive)
