"""`grabbergui files` as one types it, on a simulated camera over GigE Vision."""

import json

import pytest

from grabbergui.cli import main
from grabbergui.driver.sim.file_store import firmware_image
from grabbergui.driver.sim.gige.server import GigeCamera

SOURCE = "gige:127.28.1.1"


@pytest.fixture(autouse=True)
def camera():
    camera = GigeCamera("127.28.1.1")
    yield camera
    camera.close()


def files(*arguments):
    return main(["files", SOURCE, *map(str, arguments)])


def test_files_are_listed(capsys):
    assert files() == 0
    assert "LUTLuminance            8192 B  FileState = Intact\n" in capsys.readouterr().out
    assert files("--json") == 0
    listed = {file["name"]: file for file in json.loads(capsys.readouterr().out)}
    assert listed["LUTLuminance"]["size"] == 8192
    assert listed["LUTLuminance"]["details"] == {"FileState": "Intact"}


def test_a_file_goes_there_and_back(tmp_path, capsys):
    (tmp_path / "up.bin").write_bytes(bytes(range(250)) * 20)
    assert files("put", "ShadingCorrection", tmp_path / "up.bin") == 0
    assert capsys.readouterr().out == "ShadingCorrection: 5000 bytes written and read back\n"
    assert files("get", "ShadingCorrection", tmp_path / "down.bin", "--json") == 0
    assert json.loads(capsys.readouterr().out)["size"] == 5000
    assert (tmp_path / "down.bin").read_bytes() == (tmp_path / "up.bin").read_bytes()
    assert files("delete", "ShadingCorrection") == 0
    capsys.readouterr()
    assert files() == 0
    assert "ShadingCorrection          0 B  FileState = Empty\n" in capsys.readouterr().out


def test_nothing_on_this_computer_is_overwritten(tmp_path, capsys):
    there = tmp_path / "there.bin"
    there.write_bytes(b"mine")
    assert files("get", "LUTLuminance", there) == 2
    assert "exists already" in capsys.readouterr().err
    assert there.read_bytes() == b"mine"


def test_a_full_disk_keeps_no_part_of_a_file(tmp_path, capsys, full_disk):
    with full_disk():
        assert files("get", "LUTLuminance", tmp_path / "table.bin") == 1
    assert f"{tmp_path / 'table.bin'}: File too large" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_firmware_needs_its_warning_confirmed(tmp_path, capsys, camera):
    image = tmp_path / "new.bin"
    image.write_bytes(firmware_image("3.1.4", b"program" * 1000))
    assert files("put", "Firmware", image) == 2
    assert "may leave the camera useless" in capsys.readouterr().err
    assert files("put", "Firmware", image, "--replace-firmware") == 0
    assert "written and read back" in capsys.readouterr().out
    image.write_bytes(b"no firmware")
    assert files("put", "Firmware", image, "--replace-firmware") == 1
    assert "Close ended with FileOperationStatus Failure" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("get",), "files get takes NAME and perhaps PATH"),
        (("put", "LUTLuminance"), "files put takes NAME and PATH"),
        (("list", "LUTLuminance"), "files list takes no further argument"),
        (("get", "LUTRed"), "has no file LUTRed; it has UserSet1"),
        (("put", "LUTLuminance", "/nowhere/table.bin"), "there is no file /nowhere/table.bin"),
        (("get", "LUTLuminance", "/nowhere/table.bin"), "there is no folder /nowhere for table.bin"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments, message, capsys):
    assert files(*arguments) == 2
    assert message in capsys.readouterr().err
