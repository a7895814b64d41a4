"""Aravis's simulated camera, used as by an operator: by command line, and after it lost power."""

import json
import queue as queue_module

import pytest

from grabbergui import sources
from grabbergui.cli import main
from grabbergui.core.features import Representation
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.sfnc import FAVOURITES
from patience import PATIENCE

pytestmark = pytest.mark.aravis


def test_a_hundred_complete_frames(aravis_camera, capsys):
    assert main(["grab", "gige:127.0.0.1", "-n", "100", "--json"]) == 0

    summary = json.loads(capsys.readouterr().out)
    assert (summary["frames"], summary["incomplete"]) == (100, 0)
    assert summary["bytes"] == 100 * summary["width"] * summary["height"]


def test_a_feature_of_an_older_name_is_set_and_stays(aravis_camera, capsys):
    assert main(["set", "gige:127.0.0.1", "GainAuto=Continuous", "GainRaw=5"]) == 0
    assert main(["get", "gige:GV01", "GainRaw", "GainAuto"]) == 0

    assert capsys.readouterr().out.splitlines()[-2:] == ["GainRaw = 5", "GainAuto = Off"]


def test_an_error_out_of_range_names_the_range(aravis_camera, capsys):
    assert main(["set", "gige:", "GainRaw=11"]) == 1

    assert "GainRaw=11: out of range; allowed: 0 … 10" in capsys.readouterr().err


def test_it_is_listed(aravis_camera, capsys):
    assert main(["list", "--json", "--timeout", "0.5"]) == 0

    found = {info["uri"]: info for info in json.loads(capsys.readouterr().out)}
    assert found["gige:GV01"]["vendor"] == "Aravis" and found["gige:GV01"]["address"] == "127.0.0.1"


def test_exposure_gain_and_frame_rate_are_found_under_older_names(aravis_camera):
    grabber = sources.create("gige:")
    grabber.open()
    names = [grabber.role(role) for role in FAVOURITES]

    assert names == ["ExposureTimeAbs", "GainRaw", "AcquisitionFrameRate"]
    assert all(grabber.feature(name).representation is Representation.LINEAR for name in names)
    assert grabber.feature("ExposureTimeAbs").logarithmic
    grabber.close()


def test_a_camera_that_lost_its_power_comes_back_as_it_was(start_aravis):
    camera = start_aravis()
    states = queue_module.Queue()
    grabber = sources.create("gige:")
    grabber.open()
    grabber.connection_changed.connect(lambda state, why: states.put(state))
    queue = grabber.open_queue()
    grabber.write_feature("GainRaw", 7)
    grabber.write_feature("Width", 256)
    grabber.start()
    queue.get(PATIENCE)

    camera.kill()
    assert states.get(timeout=PATIENCE) is ConnectionState.LOST
    start_aravis()

    assert states.get(timeout=PATIENCE) is ConnectionState.OPEN
    queue.clear()
    assert queue.get(PATIENCE).width == 256
    assert grabber.feature("GainRaw").value == 7
    grabber.close()
