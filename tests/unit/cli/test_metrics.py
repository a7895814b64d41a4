"""Counters over HTTP, and logs as JSON."""

import json
import logging
from types import SimpleNamespace

import pytest

from grabbergui.cli.metrics import exposition, parse_address, read_token
from grabbergui.cli.process import JsonFormatter, TextFormatter
from grabbergui.core.errors import UsageError
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.identity import DeviceInfo


@pytest.mark.parametrize("lost", ["", "the camera did not answer for 1.2 s"])
def test_every_counter_is_there(lost):
    statistics = StreamStatistics(frames=3)
    grabber = SimpleNamespace(
        info=DeviceInfo('a"b\\'), streaming=False, lost=lost, statistics=lambda: statistics
    )
    page = exposition(grabber, {})

    samples = [line for line in page.splitlines() if not line.startswith("#")]
    assert len(samples) == len(statistics.as_dict()) + 2
    assert rf'grabbergui_camera_lost{{source="a\"b\\"}} {int(bool(lost))}' in samples
    assert r'grabbergui_frames_total{source="a\"b\\"} 3' in samples


@pytest.mark.parametrize("text", ["", "\n", None])
def test_a_token_that_is_none(tmp_path, text):
    path = tmp_path / "token"
    if text is not None:
        path.write_text(text)
    with pytest.raises(UsageError, match="--metrics-token"):
        read_token(str(path))


def test_addresses():
    assert parse_address("9100") == ("127.0.0.1", 9100)
    assert parse_address("0.0.0.0:80") == ("0.0.0.0", 80)
    for bad in ("", "host", "host:", "1:99999", "1:²"):
        with pytest.raises(UsageError, match="write HOST:PORT"):
            parse_address(bad)


def test_a_log_line_is_one_json_object():
    record = logging.LogRecord("a.b", logging.WARNING, "", 0, "lost\n%s", ("camera 1",), None)

    line = JsonFormatter().format(record)

    entry = json.loads(line)
    assert "\n" not in line
    assert (entry["level"], entry["logger"], entry["message"]) == ("warning", "a.b", "lost\ncamera 1")
    assert entry["time"].endswith("+00:00")


def test_a_peers_name_neither_forges_a_log_line_nor_controls_the_terminal():
    name = "/peer\n2026-11-25 00:00:00,000 CRITICAL a.b: all is lost\r\x1b]0;title\x07\x9b31m"
    record = logging.LogRecord("a.b", logging.WARNING, "", 0, "connection from %s", (name,), None)

    first, *rest = TextFormatter().format(record).split("\n")

    assert first.endswith("WARNING a.b: connection from /peer")
    assert rest == [
        r"    2026-11-25 00:00:00,000 CRITICAL a.b: all is lost\r\x1b]0;title\x07\x9b31m",
    ]
