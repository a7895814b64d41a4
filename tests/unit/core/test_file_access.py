"""Files in a camera, through every layer: the simulated camera in this process."""

import threading

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.errors import (
    CameraFileError,
    FeatureAccessError,
    FeatureError,
    TransferCancelledError,
    TransportError,
    UsageError,
)
from grabbergui.core.file_access import delete_file, is_firmware, list_files, read_file, write_file
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.shared import ReadOnlyGrabber, SharedGrabber
from grabbergui.driver.sim.file_store import LUT_ENTRIES, firmware_image

GAMMA = (np.linspace(0, 1, LUT_ENTRIES) ** 0.5 * 65535).astype("<u2").tobytes()
FIRMWARE = firmware_image("2.0.0", np.random.default_rng(7).bytes(30_001))


@pytest.fixture
def camera():
    grabber = sources.create("sim:")
    grabber.open()
    yield grabber
    grabber.close()


def state(camera, name):
    return camera.read_setting(SettingKey("FileState", (("FileSelector", name),))).value


def test_files_are_listed_with_size_and_state(camera):
    files = {file.name: file for file in list_files(camera)}
    assert list(files) == [
        "UserSet1",
        "UserSet2",
        "LUTLuminance",
        "ShadingCorrection",
        "DeviceLog",
        "Firmware",
    ]
    assert files["LUTLuminance"].size == 8192
    assert files["LUTLuminance"].details == {"FileState": "Intact"}
    assert files["LUTLuminance"].modes == ("Read", "Write", "ReadWrite")
    assert [name for name in files if is_firmware(name)] == ["Firmware"]


def test_a_written_file_is_read_back(camera):
    seen = []
    written = write_file(camera, "LUTLuminance", GAMMA, progress=lambda done, of: seen.append((done, of)))
    assert (written.size, written.verified) == (8192, True)
    assert seen == [(4096, 16384), (8192, 16384), (12288, 16384), (16384, 16384)]
    assert read_file(camera, "LUTLuminance") == GAMMA


@pytest.mark.parametrize("length", [0, 1, 3, 4095, 4096, 4097, 32_768])
def test_any_length_arrives(camera, length):
    content = np.random.default_rng(length).bytes(length)
    assert write_file(camera, "ShadingCorrection", content).verified
    assert read_file(camera, "ShadingCorrection") == content
    assert {file.name: file.size for file in list_files(camera)}["ShadingCorrection"] == length


def test_selectors_are_restored(camera):
    for name, value in (("FileSelector", "DeviceLog"), ("FileOperationSelector", "Delete")):
        camera.write_feature(name, value)
    camera.write_feature("FileOpenMode", "ReadWrite")
    write_file(camera, "LUTLuminance", GAMMA)
    list_files(camera)
    names = ("FileSelector", "FileOperationSelector", "FileOpenMode")
    assert [camera.feature(name).value for name in names] == ["DeviceLog", "Delete", "ReadWrite"]


def test_a_transfers_features_are_not_restored_after_a_loss(camera):
    camera.write_feature("Gain", 3.0)
    write_file(camera, "LUTLuminance", GAMMA)
    assert [key.name for key in camera._writes().memory.settings if key.name.startswith("File")] == []


def test_other_callers_never_see_the_selector_of_a_transfer(camera):
    camera.write_feature("FileSelector", "DeviceLog")
    seen, done = [], threading.Event()

    def look():
        while not done.is_set():
            seen.append(camera.feature("FileSelector").value)

    watcher = threading.Thread(target=look)
    watcher.start()
    try:
        for _ in range(3):
            read_file(camera, "Firmware")
    finally:
        done.set()
        watcher.join()
    assert set(seen) == {"DeviceLog"}


def test_a_user_set_is_a_file(camera):
    camera.write_feature("Gamma", 2.0)
    camera.write_feature("UserSetSelector", "UserSet1")
    camera.execute("UserSetSave")
    saved = read_file(camera, "UserSet1")
    assert b"Gamma = 2.0\n" in saved
    write_file(camera, "UserSet2", saved.replace(b"Gamma = 2.0", b"Gamma = 3.0"))
    camera.write_feature("UserSetSelector", "UserSet2")
    camera.execute("UserSetLoad")
    assert camera.feature("Gamma").value == 3.0


@pytest.mark.parametrize("content", [b"Gamma = much\n", b"Sesame = open\n", b"Gamma = 1000\n", b"\xff\x00"])
def test_an_invalid_user_set_changes_nothing(camera, content):
    camera.write_feature("Gamma", 2.0)
    write_file(camera, "UserSet1", content)
    camera.write_feature("UserSetSelector", "UserSet1")
    with pytest.raises(FeatureError, match="UserSetLoad"):
        camera.execute("UserSetLoad")
    assert camera.feature("Gamma").value == 2.0


def test_a_deleted_file_is_empty(camera):
    delete_file(camera, "ShadingCorrection")
    assert read_file(camera, "ShadingCorrection") == b""
    assert state(camera, "ShadingCorrection") == "Empty"


def test_errors_name_operation_file_and_status(camera):
    with pytest.raises(CameraFileError, match=r"writing DeviceLog: Open ended with.* Failure") as refusal:
        write_file(camera, "DeviceLog", b"nothing happened")
    assert (refusal.value.file, refusal.value.operation, refusal.value.status) == (
        "DeviceLog",
        "Open",
        "Failure",
    )
    with pytest.raises(CameraFileError, match=r"after 8192 bytes: Write ended with.* Overflow"):
        write_file(camera, "LUTLuminance", bytes(9000))
    with pytest.raises(CameraFileError, match=r"deleting DeviceLog: Delete ended with.* Failure"):
        delete_file(camera, "DeviceLog")
    with pytest.raises(UsageError, match=r"has no file LUTRed; it has UserSet1, .*Firmware"):
        read_file(camera, "LUTRed")


def test_a_cancelled_upload_reports_its_progress(camera):
    cancelled = threading.Event()

    def stop(done, of):
        cancelled.set()

    with pytest.raises(TransferCancelledError, match="writing LUTLuminance after 4096 bytes: cancelled"):
        write_file(camera, "LUTLuminance", GAMMA, progress=stop, cancelled=cancelled)
    assert read_file(camera, "LUTLuminance") == GAMMA[:4096]


def test_firmware_is_replaced_only_on_purpose(camera):
    before = read_file(camera, "Firmware")
    with pytest.raises(UsageError, match="may leave the camera useless"):
        write_file(camera, "Firmware", FIRMWARE)
    with pytest.raises(UsageError, match="never deleted"):
        delete_file(camera, "Firmware")
    assert read_file(camera, "Firmware") == before
    assert write_file(camera, "Firmware", FIRMWARE, replace_firmware=True).verified
    assert camera.feature("DeviceFirmwareVersion").value == "1.0.0"
    camera.execute("DeviceReset")
    camera._nodes.invalidate(frozenset({"DeviceFirmwareVersion"}))
    assert camera.feature("DeviceFirmwareVersion").value == "2.0.0"


def test_damaged_firmware_is_refused_by_the_camera(camera):
    before = read_file(camera, "Firmware")
    with pytest.raises(CameraFileError, match=r"after 30025 bytes: Close ended with.* Failure"):
        write_file(camera, "Firmware", FIRMWARE[:-1] + b"!", replace_firmware=True)
    assert state(camera, "Firmware") == "Discarded"
    assert read_file(camera, "Firmware") == before


def test_a_file_that_reads_back_differently_is_an_error(camera, monkeypatch):
    honest = type(camera).read_register
    monkeypatch.setattr(
        type(camera), "read_register", lambda self, name, length: honest(self, name, length)[:-1] + b"\x99"
    )
    with pytest.raises(CameraFileError, match=r"reads back differently.*first difference at byte 4095"):
        write_file(camera, "LUTLuminance", bytes(8192))


def test_monitor_access_is_refused_before_a_file_is_opened():
    grabber = sources.create("sim:")
    grabber.open(Access.MONITOR)
    with grabber.exclusive(), pytest.raises(UsageError, match="open for reading"):
        read_file(grabber, "LUTLuminance")
    grabber.close()


def test_a_shared_grabber_passes_files_on_and_a_read_only_one_refuses(camera):
    assert read_file(SharedGrabber(camera), "LUTLuminance") == read_file(camera, "LUTLuminance")
    with pytest.raises(UsageError, match="open for reading"):
        write_file(ReadOnlyGrabber(camera), "LUTLuminance", GAMMA)
    with pytest.raises(FeatureAccessError, match="FileAccessBuffer"):
        ReadOnlyGrabber(camera).write_register("FileAccessBuffer", b"")


class RemoteGrabber(SharedGrabber):
    """Features travel, registers do not."""

    register_length = FrameGrabber.register_length
    read_register = FrameGrabber.read_register
    write_register = FrameGrabber.write_register


def test_a_remote_source_lists_files_and_refuses_transfers(camera):
    remote = RemoteGrabber(camera)
    assert list_files(remote) == list_files(camera)
    for transfer in (
        lambda: read_file(remote, "LUTLuminance"),
        lambda: write_file(remote, "LUTLuminance", b""),
    ):
        with pytest.raises(FeatureAccessError, match="FileAccessBuffer; only a camera that is attached"):
            transfer()
    assert read_file(camera, "LUTLuminance")


def test_a_lost_camera_is_reported_with_the_advice_to_repeat_the_upload(camera, monkeypatch):
    def lose(self, name, content):
        raise TransportError("no acknowledge")

    monkeypatch.setattr(type(camera), "write_register", lose)
    with pytest.raises(TransportError, match=r"writing LUTLuminance: no acknowledge; it cannot be resumed"):
        write_file(camera, "LUTLuminance", GAMMA)


@pytest.mark.parametrize("name", ["Firmware", "MainBootloader", "FPGA1", "Bitstream"])
def test_files_that_make_a_camera_useless_are_recognised(name):
    assert is_firmware(name) and not is_firmware("UserSet1")
