"""Look-up tables: made, kept in files, read from and written to a camera, all at once or entry by entry."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from every_case import every_case
from grabbergui import sources
from grabbergui.core import lookup_table
from grabbergui.core.errors import FeatureAccessError, TransferCancelledError, UsageError
from grabbergui.core.file_access import read_file
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.lookup_table import (
    LutShape,
    gamma_of,
    gamma_table,
    has_lut,
    load_table,
    read_table,
    save_table,
    selectors_of,
    shape_of,
    write_table,
)

SHAPE = LutShape(16, 255, whole=False)


@pytest.fixture
def camera() -> Iterator[FrameGrabber]:
    grabber = sources.create("sim:?width=160&height=120")
    grabber.open()
    yield grabber
    grabber.close()


@every_case("entries, maximum", [(256, 255), (4096, 65535), (1024, 1023)])
@every_case("gamma", [0.05, 0.1, 0.45, 0.4545, 1.0, 2.2, 10.0, 20.0])
def test_the_gamma_of_a_curve_is_found(gamma: float, entries: int, maximum: int) -> None:
    shape = LutShape(entries, maximum, whole=True)
    assert gamma_of(shape, gamma_table(shape, gamma)) == pytest.approx(gamma, rel=0.02)


def test_another_curve_has_no_gamma() -> None:
    linear = gamma_table(SHAPE, 1.0)
    assert gamma_of(SHAPE, linear) == 1.0
    for table in (linear[::-1], np.zeros_like(linear), linear // 2, np.minimum(2 * linear, 255)):
        assert gamma_of(SHAPE, table) is None


def test_a_gamma_spans_the_whole_range() -> None:
    linear = gamma_table(SHAPE, 1.0)
    assert linear.tolist() == [17 * place for place in range(16)]
    bright = gamma_table(SHAPE, 0.5)
    assert (bright >= linear).all() and (bright[[0, -1]] == [0, 255]).all() and bright[4] > linear[4]
    with pytest.raises(UsageError, match=r"allowed: 0\.05 to 20"):
        gamma_table(SHAPE, 0.0)


@pytest.mark.parametrize("name", ["lut.csv", "lut.txt", "lut.bin"])
def test_a_file_is_read_as_it_was_written(tmp_path: Path, name: str) -> None:
    table = gamma_table(SHAPE, 2.2)
    save_table(tmp_path / name, table)
    assert np.array_equal(load_table(tmp_path / name, SHAPE), table)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("1\n2\n3\n", "has 3 values from 1 to 3"),
        ("", "has 0 values"),
        ("one\ntwo\nthree\n", "cannot be read"),
        ("1\n99999999999999999999\n", "cannot be read"),
        ("\n".join(f"{15 - place},{place}" for place in range(16)), "indices do not count"),
        ("\n".join(str(20 * place) for place in range(16)), "from 0 to 255"),
        ("index,value\n0,0\n1,nan\n", "'nan' in line 3 is not a whole number"),
        ("0\n16.5\n", "'16.5' in line 2 is not a whole number"),
        ("0,1,2\n3,4,5\n", "line 1 has 3 columns"),
        ("0\n" * (1 << 22), "too long for a look-up table"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    path = tmp_path / "lut.csv"
    path.write_text(text)
    with pytest.raises(UsageError, match=problem):
        load_table(path, SHAPE)
    with pytest.raises(UsageError, match="cannot be read"):
        load_table(tmp_path / "missing.bin", SHAPE)


def test_tables_in_other_csv_styles_are_read(tmp_path: Path) -> None:
    path = tmp_path / "lut.csv"
    path.write_text(",".join(str(place) for place in range(16)))
    assert load_table(path, SHAPE).tolist() == list(range(16))
    path.write_text("index;value\n" + "\n".join(f"{place};{place}" for place in range(16)))
    assert load_table(path, SHAPE).tolist() == list(range(16))
    for line in ("{0}\t{0}", "{0} {0}.000", " {0}, {0:e}", "{0}"):  # spreadsheets, numpy.savetxt
        lines = "\n".join(line.format(place) for place in range(16))
        path.write_text(lines, encoding="utf-8-sig")
        assert load_table(path, SHAPE).tolist() == list(range(16))


def test_binary_files_that_are_no_tables_are_refused(tmp_path: Path) -> None:
    (path := tmp_path / "lut.bin").write_bytes(b"abc")
    with pytest.raises(UsageError, match="3 bytes are not 16-bit values"):
        load_table(path, SHAPE)


def test_values_beyond_16_bits_need_text(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"save it as \.csv"):
        save_table(tmp_path / "lut.bin", np.array([0, 70_000]))


@pytest.mark.parametrize("name", ["gamma.csv", "gamma.bin"])
def test_a_full_disk_leaves_the_old_table(
    tmp_path: Path, full_disk: Callable[[], AbstractContextManager[None]], name: str
) -> None:
    (path := tmp_path / name).write_text("old")
    with full_disk(), pytest.raises(OSError, match="too large"):
        lookup_table.save_table(path, np.arange(256))
    assert path.read_text() == "old"


def test_a_table_is_written_at_once_and_is_in_the_file_too(camera: FrameGrabber) -> None:
    assert has_lut(camera) and selectors_of(camera) == ("Luminance",)
    shape = shape_of(camera)
    assert shape == LutShape(4096, 65535, whole=True)
    assert read_table(camera, "Luminance").tolist() == [16 * place for place in range(4096)]
    camera.write_feature("LUTIndex", 7)
    wanted = gamma_table(shape, 0.45)
    reports: list[tuple[int, int]] = []
    write_table(camera, wanted, "Luminance", progress=lambda done, of: reports.append((done, of)))
    assert reports == [(4096, 4096)]
    assert np.array_equal(read_table(camera), wanted)
    assert camera.feature("LUTIndex").value == 7, "put back"
    assert np.array_equal(np.frombuffer(read_file(camera, "LUTLuminance"), "<u2"), wanted)


def test_without_the_register_every_entry_that_differs_is_written(
    camera: FrameGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(name: str) -> int:
        raise FeatureAccessError("it does not travel", name)

    monkeypatch.setattr(camera, "register_length", refused)
    monkeypatch.setattr(lookup_table, "shape_of", lambda grabber: LutShape(64, 65535, whole=False))
    before = read_table(camera)
    wanted = before.copy()
    wanted[[3, 60]] = 999
    written: list[object] = []
    write = camera.write_feature

    def noted(name: str, value: object) -> object:
        if name == "LUTValue":
            written.append(value)
        return write(name, value)  # type: ignore[arg-type]

    monkeypatch.setattr(camera, "write_feature", noted)
    reports: list[int] = []
    write_table(camera, wanted, progress=lambda done, of: reports.append(done))
    assert written == [999, 999] and reports == list(range(1, 65))
    assert np.array_equal(read_table(camera), wanted)

    cancelled = threading.Event()
    cancelled.set()
    with pytest.raises(TransferCancelledError, match="after 0 of 64"):
        read_table(camera, cancelled=cancelled)


@pytest.mark.parametrize("order", ["<", ">"])
def test_the_byte_order_is_recognised(
    camera: FrameGrabber, monkeypatch: pytest.MonkeyPatch, order: str
) -> None:
    content = bytearray((np.arange(4096) * 16).astype(f"{order}u2").tobytes())
    monkeypatch.setattr(camera, "read_register", lambda name, length: bytes(content[:length]))
    monkeypatch.setattr(camera, "write_register", lambda name, data: content.__setitem__(slice(None), data))
    assert read_table(camera).tolist() == [16 * place for place in range(4096)]
    wanted = gamma_table(shape_of(camera), 2.0)
    write_table(camera, wanted)
    assert np.array_equal(np.frombuffer(bytes(content), f"{order}u2"), wanted)


class Table:
    """A camera whose table of 256 entries lies in LUTValueAll in one of the byte orders."""

    def __init__(self, order: str, values: np.ndarray) -> None:
        self.dtype = np.dtype(f"{order}u2")
        self.table = values.astype(self.dtype)
        self.index = 0
        self.info = SimpleNamespace(title="a camera")
        self.readable = True

    def has_feature(self, name: str) -> bool:
        return name in ("LUTIndex", "LUTValue")

    def exclusive(self, names: object) -> contextlib.AbstractContextManager[None]:
        return contextlib.nullcontext()

    def feature(self, name: str) -> SimpleNamespace:
        value = int(self.table[self.index]) if self.readable else None
        maximum = 255 if name == "LUTIndex" else 65535
        return SimpleNamespace(value=value, maximum=maximum, access_problem=lambda: "is write-only")

    def write_feature(self, name: str, value: int) -> None:
        if name == "LUTIndex":
            self.index = value
        else:
            self.table[self.index] = value

    def register_length(self, name: str) -> int:
        return self.table.nbytes

    def read_register(self, name: str, length: int) -> bytes:
        return self.table.tobytes()[:length]

    def write_register(self, name: str, content: bytes) -> None:
        self.table = np.frombuffer(content, self.dtype).copy()


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("before", [257 * np.arange(256), np.zeros(256), np.where(np.arange(256) == 3, 7, 0)])
def test_the_byte_order_is_right_where_the_table_before_does_not_show_it(
    order: str, before: np.ndarray
) -> None:
    camera: Any = Table(order, before)
    assert read_table(camera).tolist() == before.tolist()
    wanted = gamma_table(shape_of(camera), 2.0)
    write_table(camera, wanted)
    assert camera.table.tolist() == wanted.tolist() == read_table(camera).tolist()


def test_an_unreadable_table_is_written_and_does_not_read_as_zeros(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    camera: Any = Table("<", np.arange(256))
    camera.register_length, camera.readable = lambda name: 0, False
    with pytest.raises(
        FeatureAccessError, match="entry 0 of the look-up table cannot be read: it is write-only"
    ):
        read_table(camera)
    write_table(camera, np.zeros(256, np.int64))
    assert not camera.table.any()


def test_a_table_of_another_shape_or_an_unknown_layout_is_refused(
    camera: FrameGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(UsageError, match="has 4096 entries from 0 to 65535; this one has 3"):
        write_table(camera, np.array([1, 2, 3]))
    with pytest.raises(UsageError, match="this one has 0 values"):
        write_table(camera, np.array([], np.int64))
    monkeypatch.setattr(camera, "read_register", lambda name, length: b"\x5a" * length)
    with pytest.raises(UsageError, match="its layout is not known"):
        read_table(camera)
