"""The short benchmarks run, so that they keep up with the code that they measure."""

import pytest

pytest.importorskip("benchmarks", reason="benchmarks/ is found from the checkout: python -m pytest")

from benchmarks import _gige_receivers, end_to_end, gige_peers, sim_render, yarp_ports
from benchmarks._wire import NoWireError
from patience import PATIENCE


def test_the_sensor_is_measured():
    section = sim_render.measure(["--formats", "Mono8"])

    ((name, *_, share),) = section.tables[0].rows
    assert name == "Mono8" and share.endswith("%")
    assert [goal.measured for goal in section.goals] == [share]


def test_yarp_streams_and_requests_are_measured():
    options = ["--sizes", "640×480", "--carriers", "fast_tcp", "--seconds", "0.2", "--rounds", "1"]

    section = yarp_ports.measure(options)

    streams, ages, trips = (table.rows for table in section.tables)
    ours = next(row for row in streams if row[2] == "ours → ours")
    assert int(ours[3]) > 0
    assert next(row for row in ages if row[0] == "ours → ours")[1] != "nan ms"
    assert float(next(row for row in trips if row[0] == "ours asks ours")[1].removesuffix(" ms")) > 0


@pytest.mark.netns
def test_the_way_from_the_camera_to_a_reader_is_measured(monkeypatch):
    monkeypatch.setattr(end_to_end, "has_aravis_camera", lambda: False)
    monkeypatch.setattr(end_to_end, "SETTLING", 0.2)
    monkeypatch.setattr(end_to_end, "PATIENCE", PATIENCE)

    try:
        section = end_to_end.measure(["--seconds", "1", "--rounds", "1"])
    except NoWireError as missing:
        pytest.skip(str(missing))

    ((server, rate, *figures),) = section.tables[0].rows
    assert (server, section.lacking) == (end_to_end.OURS, "AravisCamera")
    # A busy machine may send no image within a second, but the first one must arrive.
    assert float(rate) >= 0 and all(figure.endswith(" ms") for figure in figures)


def test_a_latency_that_cannot_be_measured_says_why(monkeypatch):
    run = _gige_receivers.Run(3, 0, 0.1, 0.01)
    receivers = {"ours": lambda *_: run, "Aravis": _gige_receivers.time_aravis}
    monkeypatch.setattr(gige_peers, "timed_receivers", lambda: receivers)
    monkeypatch.setattr(gige_peers, "observe", lambda case, seconds, receive: (receive(1, 1), [0.001, 0.002]))
    monkeypatch.setattr(_gige_receivers, "SYSTEM_PYTHON", "/missing/python3")

    table, goals = gige_peers.latency_table(0.1, 2)

    ours, aravis = table.rows[:2]
    assert ours[1:3] == ["ours", "1.50 ms"]
    assert aravis[1:3] == ["Aravis", "not measured: python3-gi and gir1.2-aravis-0.8 are not installed"]
    assert goals == []
