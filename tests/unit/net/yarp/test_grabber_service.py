"""The RPC port's replies, and how our client reads them, without a socket between the two."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import FeatureError, FeatureNotFoundError, FeatureValueError, UsageError
from grabbergui.core.features import AccessMode, FeatureKind
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.net import tree
from grabbergui.net.numbered_features import FeatureId
from grabbergui.net.yarp import grabber_service, grabber_values, image
from grabbergui.net.yarp.client_numbers import NumberFeatures
from grabbergui.net.yarp.grabber_rpc import (
    Call,
    CallReply,
    Operation,
    ReturnValue,
    encode_request,
    read_reply,
)
from grabbergui.net.yarp.grabber_service import GrabberService
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Dialect
from patience import PATIENCE

pytestmark = pytest.mark.parametrize("dialect", Dialect, ids=["3.x", "4.0"], indirect=False)


@pytest.fixture
def grabber() -> Iterator[FrameGrabber]:
    grabber = sources.create("sim:")
    grabber.open()
    grabber.write_feature("Width", 168)
    grabber.write_feature("Height", 100)
    grabber.start()
    yield grabber
    grabber.close()


@pytest.fixture
def service(grabber: FrameGrabber) -> Iterator[GrabberService]:
    service = GrabberService(grabber)
    yield service
    service.close()


class Wire:
    """Asks a service in one dialect, through the bytes of both ways."""

    def __init__(self, service: GrabberService, dialect: Dialect) -> None:
        self.service = service
        self.dialect = dialect
        self.asked = 0

    def ask(self, operation: Operation, *arguments: object) -> CallReply:
        self.asked += 1
        if self.dialect is Dialect.YARP4 and not operation.method:
            return CallReply(status=ReturnValue.NOT_IMPLEMENTED)
        call = Call(operation, arguments, self.dialect)  # type: ignore[arg-type]
        answer = self.service.answer(Bottle.decode(encode_request(call)))
        return read_reply(call, Bottle.decode(b"".join(answer), self.dialect))

    def typed(self, line: str) -> str:
        answer = b"".join(self.service.answer(Bottle.from_text(line)))
        return Bottle.decode(answer).to_text()


@pytest.fixture
def wire(service: GrabberService, dialect: Dialect) -> Wire:
    return Wire(service, dialect)


def test_every_request_is_answered(wire: Wire) -> None:
    samples = {"INT": 1, "FLOAT": 0.5, "FLAG": True, "VERTICES": ((0, 0), (5, 5))}
    for operation in Operation:
        arguments = [samples[kind.name] for kind in operation.arguments]
        assert isinstance(wire.ask(operation, *arguments), CallReply)


def test_a_camera_is_described(wire: Wire, grabber: FrameGrabber) -> None:
    assert wire.ask(Operation.WIDTH).values == (168,)
    assert wire.ask(Operation.GET_RESOLUTION).values == (168, 100)
    bus, text = wire.ask(Operation.DESCRIPTION).values
    assert (bus, str(text).endswith(grabber.info.model)) == (0, True)
    (configurations,) = wire.ask(Operation.CONFIGURATIONS).values
    assert [c[:2] for c in configurations] == [(168, 100)]  # type: ignore[union-attr, index]
    assert not wire.ask(Operation.INTRINSICS).ok
    assert not wire.ask(Operation.GET_FIELD_OF_VIEW).ok


def test_a_calibration_gives_intrinsics_and_field_of_view(grabber: FrameGrabber, dialect: Dialect) -> None:
    calibration = FittedCalibration(grabber)
    matrix = np.array([[200.0, 0, 83.5], [0, 250.0, 49.5], [0, 0, 1]])
    calibration.calibration = Calibration(168, 100, matrix, np.array([-0.2, 0.1, 0.01, 0.02, 0.3]))
    service = GrabberService(grabber, calibration=calibration)
    wire = Wire(service, dialect)

    (reported,) = wire.ask(Operation.INTRINSICS).values
    assert isinstance(reported, Mapping)
    names = (
        "focalLengthX",
        "focalLengthY",
        "principalPointX",
        "principalPointY",
        "k1",
        "k2",
        "t1",
        "t2",
        "k3",
    )
    assert [reported[name] for name in names] == [200, 250, 83.5, 49.5, -0.2, 0.1, 0.01, 0.02, 0.3]
    assert reported["distortionModel"] == "plumb_bob"
    angles = [2 * math.degrees(math.atan(half)) for half in (84 / 200, 50 / 250)]
    assert wire.ask(Operation.GET_FIELD_OF_VIEW).values == pytest.approx(angles)

    calibration.assume_settings()  # as a server does at its start
    grabber.write_feature("BinningHorizontal", 2)
    assert grabber.feature("Width").value == 168  # of a sensor with half as many columns
    (reported,) = wire.ask(Operation.INTRINSICS).values
    assert isinstance(reported, Mapping)
    assert (reported["focalLengthX"], reported["focalLengthY"]) == (100, 250)
    assert not wire.ask(Operation.SET_FIELD_OF_VIEW, 30.0, 20.0).ok
    service.close()


def test_images_and_their_parts_are_returned_with_padded_lines(wire: Wire) -> None:
    (whole,) = wire.ask(Operation.IMAGE).values
    header, pixels = image.decode(bytes_of(whole))
    assert (header.code, header.row_bytes, pixels.shape) == ("rgb", 504, (100, 168, 3))
    assert len(np.unique(pixels)) > 1
    (part,) = wire.ask(Operation.CROP, 0, ((10, 20), (14, 29))).values
    header, pixels = image.decode(bytes_of(part))
    assert (header.row_bytes, pixels.shape) == (16, (10, 5, 3))  # rows of 15 bytes are padded
    if wire.dialect is Dialect.YARP3:
        (raw,) = wire.ask(Operation.RAW_IMAGE).values
        header, pixels = image.decode(bytes_of(raw))
        assert (header.code, pixels.shape) == ("mono", (100, 168))


def bytes_of(image: object) -> bytes:
    mat, code, layout, pixels = image  # type: ignore[misc]
    return Bottle([mat, code, Bottle(layout, specialised=True), pixels], specialised=False).encode()


def test_a_crop_includes_both_corners_and_must_lie_within_the_image(wire: Wire) -> None:
    whole = wire.ask(Operation.CROP, 0, ((167, 99), (0, 0)))
    assert whole.values[0][2][3:] == [168, 100]  # type: ignore[index]
    part = wire.ask(Operation.CROP, 0, ((2, 3), (2, 3)))
    assert part.values[0][2][3:] == [1, 1]  # type: ignore[index]
    for kind, vertices in ((0, ((0, 0), (168, 5))), (0, ((-1, 0), (5, 5))), (0, ((1, 1),)), (1, ()), (9, ())):
        assert not wire.ask(Operation.CROP, kind, vertices).ok


def test_resolution_and_mirror_are_set_together_or_not_at_all(wire: Wire, grabber: FrameGrabber) -> None:
    assert wire.ask(Operation.SET_RESOLUTION, 320, 240).ok
    assert wire.ask(Operation.GET_RESOLUTION).values == (320, 240)
    assert wire.ask(Operation.SET_RESOLUTION, 10**6, 240).status is not ReturnValue.OK
    assert wire.ask(Operation.SET_RESOLUTION, 160, 10**6).status is not ReturnValue.OK
    assert wire.ask(Operation.GET_RESOLUTION).values == (320, 240)
    assert wire.ask(Operation.SET_MIRROR, True).ok
    assert wire.ask(Operation.GET_MIRROR).values == (True,)
    assert grabber.feature("ReverseX").value is True


def test_typed_requests_are_answered(wire: Wire, grabber: FrameGrabber) -> None:
    gain = grabber.feature("Gain")
    assert wire.typed("fgc has feat 8") == "[fgc] [has] [feat] 1952540006 1"
    assert wire.typed("fgc set feat 8 5") == "[fgc] [set] 1"
    assert wire.typed("fgc get feat 8") == "[fgc] [feat] [is] 5.0"
    assert wire.typed("fgc get fea2 8") == f"[fgc] [fea2] [is] {gain.minimum:.1f} {gain.maximum:.1f}"
    assert wire.typed("fgc set feat 8 5000") == "[fgc] [set] 0"
    assert grabber.feature("Gain").value == 5.0
    assert wire.typed("genicam write Gain 6.5").startswith('genicam ok "{')
    assert grabber.feature("Gain").value == 6.5


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("fgc set feat 8", "'fgc set feat 8': nothing where a number is expected"),
        ("fgc get foo 8", "'fgc get foo 8' is not known"),
        ("setFeature1RPC 8", "setFeature1RPC 8': nothing where a number is expected"),
        ("getPowerDC1394RPC", "'getPowerDC1394RPC' is not known; `help` lists the requests"),
        ("getFPSDC1394RPC", "getFPSDC1394RPC is for FireWire cameras"),
        (f"grab ({'x ' * 99}) now", "'grab … now' is not known"),
    ],
)
def test_the_log_contains_why_a_request_is_refused(
    wire: Wire, caplog: pytest.LogCaptureFixture, line: str, reason: str
) -> None:
    with caplog.at_level(logging.INFO):
        wire.typed(line)
    assert reason in caplog.text


def test_clients_wait_together_for_a_camera_that_sends_nothing(
    wire: Wire, grabber: FrameGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    grabber.stop()
    waits: list[float] = []
    monkeypatch.setattr(grabber_service, "frame_wait", lambda *_: waits.append(0.5) or waits[-1])
    with ThreadPoolExecutor(5) as pool:
        replies = list(pool.map(lambda _: wire.ask(Operation.IMAGE), range(5)))
    assert not any(reply.ok for reply in replies)
    assert len(waits) < len(replies), "each client waited on its own, after all before it"


def test_a_service_that_ends_lets_no_client_wait(
    wire: Wire, grabber: FrameGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    grabber.stop()
    waiting = threading.Event()
    monkeypatch.setattr(grabber_service, "frame_wait", lambda *_: waiting.set() or 2 * PATIENCE)
    with ThreadPoolExecutor(2) as pool:
        replies = [pool.submit(wire.ask, Operation.IMAGE) for _ in range(2)]
        assert waiting.wait(PATIENCE)
        wire.service.close()
        assert not any(reply.result(PATIENCE).ok for reply in replies)


def test_numbers_become_named_features(wire: Wire, grabber: FrameGrabber) -> None:
    remote = NumberFeatures(wire.ask)
    exposure, local = remote.read("ExposureTime"), grabber.feature("ExposureTime")
    assert (exposure.value, exposure.minimum, exposure.maximum) == (local.value, local.minimum, local.maximum)
    assert (exposure.unit, exposure.auto) == ("us", "ExposureAuto")
    assert remote.read("Width").value == 168
    assert remote.read("Width").access is AccessMode.READ_ONLY
    assert remote.read("DeviceModelName").value
    names = {description.name for description in remote.tree.descriptions()}
    assert {"Gain", "GainAuto", "AcquisitionFrameRate", "AcquisitionFrameRateEnable", "Shutter"} <= names
    assert all(remote.has(name) for name in names)


def test_writing_by_number_switches_the_automatic_mode_off_and_refuses_like_the_camera(
    wire: Wire, grabber: FrameGrabber
) -> None:
    remote = NumberFeatures(wire.ask)
    remote.write("ExposureAuto", "Continuous")
    assert grabber.feature("ExposureAuto").value == "Continuous"
    assert remote.write("ExposureTime", "1500").value == 1500.0
    assert grabber.feature("ExposureAuto").value == "Off"
    assert remote.read("ExposureAuto").value == "Off"
    with pytest.raises(FeatureValueError, match="allowed:"):
        remote.write("ExposureTime", 1e12)
    with pytest.raises(FeatureError, match="read-only"):
        remote.write("Width", 20)
    assert remote.write("AcquisitionFrameRateEnable", False).value is False
    # The server refuses this although it reported no limits.
    wire.ask(Operation.SET_MODE, 1, 2)
    assert remote.read("ExposureAuto").value == "Continuous"


def test_normalised_servers_are_noticed(grabber: FrameGrabber, dialect: Dialect) -> None:
    service = GrabberService(grabber, normalised=True)
    remote = NumberFeatures(Wire(service, dialect).ask)
    gain = remote.write("Gain", 0.5)
    assert (gain.minimum, gain.maximum, gain.unit) == (0.0, 1.0, "")
    local = grabber.feature("Gain")
    assert float(local.value or 0) == pytest.approx(float(local.maximum or 0) / 2)
    service.close()


def test_each_balance_ratio_is_written_for_itself(wire: Wire, grabber: FrameGrabber) -> None:
    if not NumberFeatures(wire.ask).has("BalanceRatio"):
        grabber.write_feature("PixelFormat", "BayerRG8")
    remote = NumberFeatures(wire.ask)
    remote.write("BalanceRatioSelector", "Blue")
    assert remote.write("BalanceRatio", 1.75).value == 1.75
    remote.write("BalanceRatioSelector", "Red")
    assert remote.write("BalanceRatio", 1.25).value == 1.25
    grabber.write_feature("BalanceRatioSelector", "Blue")
    assert grabber.feature("BalanceRatio").value == 1.75


def test_a_balance_is_not_written_while_the_other_one_cannot_be_read(
    wire: Wire, grabber: FrameGrabber
) -> None:
    """Both travel in one request, so an invented value would be written, too."""
    grabber.write_feature("PixelFormat", "BayerRG8")
    readable = 1

    def ask(operation: Operation, *arguments: object) -> CallReply:
        nonlocal readable
        if operation is Operation.GET_VALUES and arguments == (FeatureId.WHITE_BALANCE,):
            readable -= 1
            if readable < 0:
                return CallReply(status=ReturnValue.FAILED)
        return wire.ask(operation, *arguments)

    remote = NumberFeatures(ask)
    readable = 1
    blue = SettingKey("BalanceRatio", (("BalanceRatioSelector", "Blue"),))
    before = grabber.read_setting(blue).value
    with pytest.raises(FeatureError, match="BalanceRatio: the remote camera does not report"):
        remote.write("BalanceRatio", 1.25)
    assert grabber.read_setting(blue).value == before


def test_a_server_that_has_nothing(dialect: Dialect) -> None:
    remote = NumberFeatures(lambda operation, *arguments: CallReply(status=ReturnValue.NOT_IMPLEMENTED))
    assert list(remote.tree.descriptions()) == []
    assert remote.changes() == frozenset()


def test_the_whole_tree_is_served(wire: Wire, grabber: FrameGrabber) -> None:
    def ask(verb: str, *arguments: str) -> object:
        request = Bottle.decode(grabber_values.tree_request(verb, *arguments).encode(wire.dialect))
        return grabber_values.read_tree_reply(Bottle.decode(b"".join(wire.service.answer(request))))

    assert tree.read_category(ask("tree")) == grabber.feature_tree()
    names = [description.name for description in grabber.feature_tree().descriptions()]
    volatile = {"DeviceTemperature", "Timestamp", "TimestampLatchValue"}
    for sent, local in zip(ask("feature", *names), grabber.features(), strict=True):  # type: ignore[call-overload]
        if local.name not in volatile:
            assert tree.read_feature(sent) == grabber.offered(local)
    assert tree.read_feature(ask("write", "Gain", "3")).value == 3.0
    command = next(f.name for f in grabber.features() if f.kind is FeatureKind.COMMAND and f.access.writable)
    assert ask("execute", command) is None
    with pytest.raises(FeatureNotFoundError, match="did you mean Gain"):
        ask("feature", "Gian")
    for nonsense in (("write", "Gain"), ("fly",), ("changes", "x"), ("tree", "1")):
        with pytest.raises(UsageError):
            ask(*nonsense)
    revision = ask("changes", "0")["revision"]  # type: ignore[index]
    grabber.write_feature("Gain", 4.0)
    deadline = time.monotonic() + PATIENCE
    while "Gain" not in (ask("changes", str(revision))["names"] or []):  # type: ignore[index]
        assert time.monotonic() < deadline
