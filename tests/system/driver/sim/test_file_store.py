"""Files of the simulated camera: a power cut at every step of an upload, and a network with losses."""

import random
from contextlib import closing
from functools import partial

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.errors import DeviceLostError, GrabberError, TransportError
from grabbergui.core.file_access import list_files, read_file, write_file
from grabbergui.core.identity import DeviceInfo
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.gige.control_channel import ControlTiming
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.device import SimulatedDevice
from grabbergui.driver.sim.enumerations import File
from grabbergui.driver.sim.file_store import FileStore, firmware_image
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.sim.model import CameraModel
from patience import until

FIRMWARE = firmware_image("2.0.0", np.random.default_rng(7).bytes(30_001))
BLOCKS = 8
SHADING = np.random.default_rng(8).bytes(BLOCKS * 4096)


class MainsDevice(SimulatedDevice):
    """A camera whose power is cut when it is asked to run its nth file operation."""

    operations_left = float("inf")

    def write(self, address, data):
        if address == reg.FILE_OPERATION_EXECUTE.address:
            if self.operations_left <= 0:
                self._open = False
                raise DeviceLostError("the power was cut")
            self.operations_left -= 1
        super().write(address, data)


def switched_on(store):
    camera = DeviceGrabber(MainsDevice(DeviceInfo("sim:"), CameraModel(files=store)))
    camera.open()
    return camera


def cut(store, operations, file, content):
    """Upload until the power is cut before an operation; return the camera as it comes back."""
    camera = switched_on(store)
    camera.device.operations_left = operations
    try:
        with pytest.raises(DeviceLostError, match=f"{file}.*the power was cut"):
            write_file(camera, file, content, replace_firmware=True)
    finally:
        camera.close()
    return switched_on(store)


def details(camera, name):
    (file,) = [file for file in list_files(camera) if file.name == name]
    return file.size, file.details["FileState"]


UPLOAD = 1 + BLOCKS + 1
"Operations: Open, a Write for each block, Close."


@pytest.mark.parametrize("operations", range(UPLOAD))
def test_firmware_survives_a_power_cut_at_any_step(operations):
    store = FileStore()
    old = store.content(File.FIRMWARE)
    camera = cut(store, operations, "Firmware", FIRMWARE)
    try:
        assert details(camera, "Firmware") == (len(old), "Discarded" if operations else "Intact")
        assert camera.feature("DeviceFirmwareVersion").value == "1.0.0"
        assert read_file(camera, "Firmware") == old
        logged = read_file(camera, "DeviceLog").decode()
        received = min(max(operations - 1, 0) * 4096, len(FIRMWARE))
        assert (f"after {received} bytes: the upload is discarded" in logged) == bool(operations)
        # What was cut off begins again, and is whole then.
        assert write_file(camera, "Firmware", FIRMWARE, replace_firmware=True).verified
        assert details(camera, "Firmware") == (len(FIRMWARE), "Intact")
    finally:
        camera.close()


def test_a_power_cut_while_it_is_verified_costs_nothing():
    store = FileStore()
    camera = cut(store, UPLOAD + 2, "Firmware", FIRMWARE)
    try:
        assert details(camera, "Firmware") == (len(FIRMWARE), "Intact")
        assert camera.feature("DeviceFirmwareVersion").value == "2.0.0"
    finally:
        camera.close()


@pytest.mark.parametrize("operations", range(UPLOAD))
def test_a_file_that_is_written_in_place_is_incomplete_after_a_power_cut(operations):
    store = FileStore()
    old = store.content(File.SHADING_CORRECTION)
    camera = cut(store, operations, "ShadingCorrection", SHADING)
    try:
        size, state = details(camera, "ShadingCorrection")
        if operations == 0:
            assert (size, state) == (len(old), "Intact")
        else:
            assert (size, state) == ((operations - 1) * 4096, "Incomplete")
        assert write_file(camera, "ShadingCorrection", SHADING).verified
        assert details(camera, "ShadingCorrection") == (len(SHADING), "Intact")
    finally:
        camera.close()


def test_an_open_file_is_not_opened_again():
    """Otherwise the second client would empty the file under the first."""
    with closing(switched_on(FileStore())) as camera:
        camera.write_feature("FileSelector", "ShadingCorrection")
        before = camera.feature("FileSize").value

        def status_of(operation, mode):
            camera.write_feature("FileOpenMode", mode)
            camera.write_feature("FileOperationSelector", operation)
            camera.execute("FileOperationExecute")
            return camera.feature("FileOperationStatus").value

        assert status_of("Open", "Read") == "Success"
        assert status_of("Open", "Write") == "Failure"
        assert (camera.feature("FileSize").value, before > 0) == (before, True)
        assert status_of("Close", "Read") == "Success"
        assert status_of("Open", "Write") == "Success"


def test_a_file_that_a_program_left_open_is_read_and_written():
    """One that ended during a transfer."""
    with closing(switched_on(FileStore())) as camera:
        content = read_file(camera, "ShadingCorrection")
        for transfer in (partial(read_file, camera), partial(write_file, camera, content=content)):
            camera.write_feature("FileSelector", "ShadingCorrection")
            camera.write_feature("FileOpenMode", "Read")
            camera.write_feature("FileOperationSelector", "Open")
            camera.execute("FileOperationExecute")
            transfer(name="ShadingCorrection")
        assert read_file(camera, "ShadingCorrection") == content


def test_an_incomplete_default_user_set_is_replaced_by_the_factorys():
    store = FileStore()
    camera = switched_on(store)
    whole = read_file(camera, "UserSet1")
    camera.close()
    camera = cut(store, 1, "UserSet1", whole)
    try:
        camera.write_feature("UserSetDefault", "UserSet1")
        camera.write_feature("Gamma", 2.0)
        camera.execute("DeviceReset")
        assert camera.device.model.memory.get(reg.GAMMA) == 1.0
        assert "the factory's settings are used" in read_file(camera, "DeviceLog").decode()
    finally:
        camera.close()


@pytest.fixture
def lossy(monkeypatch):
    """A camera on the loopback that loses one in forty of its acknowledges; they are not awaited for long."""
    brief = partial(ControlLink, timing=ControlTiming(ack_timeout=0.1, tries=16))
    monkeypatch.setattr("grabbergui.driver.gige.device.ControlLink", brief)
    chance = random.Random(28)

    class LossyCamera(GigeCamera):
        lost = 0

        def _transmit(self, out):
            if chance.random() < 1 / 40:
                self.lost += 1
            else:
                super()._transmit(out)

    camera = LossyCamera("127.28.0.1")
    yield camera
    camera.close()


def test_files_arrive_whole_though_acknowledges_are_lost(lossy):
    grabber = sources.create("gige:127.28.0.1")
    grabber.open()
    try:
        assert write_file(grabber, "ShadingCorrection", SHADING[:20_001]).verified
        assert read_file(grabber, "ShadingCorrection") == SHADING[:20_001]
        assert write_file(grabber, "Firmware", FIRMWARE, replace_firmware=True).verified
    finally:
        grabber.close()
    assert lossy.lost > 0


def test_a_camera_that_comes_back_says_what_became_of_its_file(lossy):
    grabber = sources.create("gige:127.28.0.1")
    grabber.open()
    try:

        def pull_the_plug(done, of):
            if done == 2 * 4096:
                lossy.cut_power()

        with pytest.raises(TransportError, match=r"ShadingCorrection after \d+ bytes.*cannot be resumed"):
            write_file(grabber, "ShadingCorrection", SHADING, progress=pull_the_plug)
    finally:
        grabber.close()

    def reachable():
        try:
            grabber.open()
        except GrabberError:
            return False
        return True

    until(reachable, "a camera that has its power again")
    try:
        size, state = details(grabber, "ShadingCorrection")
        assert (size >= 2 * 4096, state) == (True, "Incomplete")
    finally:
        grabber.close()
