"""The images of a remote camera: carriers, codes of pixels, components, and ports that send images only."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from grabber_stage import Stage, connect
from grabbergui.cli import main
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.scan3d import read_scan3d
from grabbergui.net.yarp import image
from grabbergui.net.yarp.client_stream import FORMATS, to_frame
from grabbergui.net.yarp.os import carrier
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.outputs import connect as connect_output
from grabbergui.net.yarp.os.ports import OutputPort
from patience import PATIENCE, until


@pytest.mark.parametrize("chosen", ["tcp", "udp", "mjpeg"])
def test_images_arrive_over_the_chosen_carrier(scene: Stage, chosen: str) -> None:
    with scene.share():
        remote = connect(scene, f"yarp:/grabber?carrier={chosen}")
        remote.open()
        queue = remote.open_queue()
        remote.start()
        assert queue.get(PATIENCE).rgb().shape == (100, 168, 3)
        remote.close()
        remote.close()


def test_ours_sends_mono_as_the_sensor_has_it(scene: Stage) -> None:
    with scene.share():
        remote = connect(scene)
        remote.open()
        queue = remote.open_queue()
        remote.start()
        frame = queue.get(PATIENCE)
        assert (frame.pixel_format.name, frame.nbytes) == ("Mono8", 168 * 100)
        remote.close()


def test_a_port_that_only_sends_images(scene: Stage) -> None:
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    with OutputPort("/images", scene.names) as port:
        remote = connect(scene, "yarp:/images")
        remote.open()
        assert list(remote.feature_tree().descriptions()) == []
        queue = remote.open_queue()
        remote.start()
        until(lambda: port.connections, "the connection")
        port.write(*image.encode(pixels, "rgb"))  # without an envelope
        assert np.array_equal(queue.get(PATIENCE).rgb(), pixels)
        port.write(*image.encode(np.zeros((2, 2, 3), "<f4"), "rgb."))
        port.write(b"no image")
        until(lambda: remote.statistics().packets_ignored, "a message that is no image")
        port.write(*image.encode(pixels, "rgb"))
        assert queue.get(PATIENCE).complete
        remote.close()


def test_grab_says_that_a_port_sends_no_images(scene: Stage, capsys: pytest.CaptureFixture[str]) -> None:
    over = threading.Event()

    def speak() -> None:
        while not over.wait(0.05):
            port.write_bottle(Bottle(["words"]))

    with OutputPort("/words", scene.names) as port, ThreadPoolExecutor(1) as pool:
        pool.submit(speak)
        assert main(["grab", f"yarp:/words?nameserver={scene.address}", "--timeout", "2"]) == 1
        over.set()
    assert "/words sends messages that are no images (message " in capsys.readouterr().err


def test_grab_says_over_what_a_port_is_connected_that_sends_nothing(
    scene: Stage, capsys: pytest.CaptureFixture[str]
) -> None:
    with OutputPort("/mute", scene.names):
        source = f"yarp:/mute?nameserver={scene.address}&carrier=tcp"
        assert main(["grab", source, "--timeout", "0.5"]) == 1
    assert "/mute is connected over tcp and sends nothing; see whether" in capsys.readouterr().err


def waiting(over: threading.Event) -> None:
    over.wait(PATIENCE)


def test_a_program_s_port_that_waits_for_the_rest_of_an_image(scene: Stage) -> None:
    """A BufferedPort of images reads a request as the beginning of one, and never acknowledges it."""
    over = threading.Event()
    pixels = np.zeros((4, 4, 3), np.uint8)
    with OutputPort("/program", scene.names, handler=lambda request: waiting(over)) as port:
        remote = connect(scene, "yarp:/program")
        remote.open()
        assert list(remote.feature_tree().descriptions()) == []
        queue = remote.open_queue()
        remote.start()
        until(lambda: port.connections, "the connection")
        port.write(*image.encode(pixels, "rgb"))
        assert queue.get(PATIENCE).complete
        remote.stop()
        lost = threading.Event()
        remote.connection_changed.connect(lambda state, why: state is ConnectionState.LOST and lost.set())
        over.set()
        port.close()
        assert lost.wait(PATIENCE)
        remote.close()


@pytest.mark.parametrize("code", FORMATS)
def test_every_pixel_code_becomes_a_frame(code: str) -> None:
    pixel = image.CODES[code]
    shape = (4, 6) if pixel.channels == 1 else (4, 6, pixel.channels)
    pixels = np.arange(np.prod(shape), dtype=pixel.dtype).reshape(shape)
    header, body = image.encode(pixels, code)
    frame = to_frame(header + bytes(body), "7 1234.5", 99)
    assert np.array_equal(frame.raw(), pixels)
    assert frame.rgb().shape == (4, 6, 3)
    assert (frame.frame_id, frame.timestamp_ns, frame.received_ns) == (7, 1_234_500_000_000, 99)


@pytest.mark.parametrize("shape", [(0, 0, 3), (0, 4, 3), (4, 0, 3)])
def test_an_image_without_pixels_is_refused(shape: tuple[int, ...]) -> None:
    header, _ = image.encode(np.zeros(shape, np.uint8), "rgb")
    with pytest.raises(RemoteProtocolError, match=f"image of {shape[1]}×{shape[0]} pixels is empty"):
        to_frame(header, "", 99)


def components_of(frame: Frame) -> list[str]:
    return [part.name for part in frame.components]


@pytest.fixture
def ranging(scene: Stage) -> Iterator[Stage]:
    """The camera with three components; as it was behind the test."""

    def enable(enabled: bool) -> None:
        for name in ("Range", "Confidence"):
            scene.grabber.write_feature("ComponentSelector", name)
            scene.grabber.write_feature("ComponentEnable", enabled)

    enable(True)
    yield scene
    enable(False)


def test_a_frame_has_all_components_that_the_server_sends(ranging: Stage) -> None:
    with ranging.share():
        remote = connect(ranging)
        remote.open()
        try:
            queue = remote.open_queue(2)
            remote.start()
            frame = until(lambda: len((seen := queue.get(PATIENCE)).components) == 3 and seen)
            assert components_of(frame) == ["intensity", "range", "confidence"]
            local = ranging.grabber.open_queue(1)
            theirs = read_scan3d(ranging.grabber)
            mine = read_scan3d(remote)
            wanted = next(part for part in local.get(PATIENCE).components if part.name == "range")
            part = frame.components[1]
            assert part.pixel_format.is_coordinate and mine.unit_of(part.pixel_format) == "mm"
            found = mine.distances(part.raw(), part.pixel_format)
            expected = theirs.distances(wanted.raw(), wanted.pixel_format)
            assert np.nanmin(found) > 500 and np.nanmax(found) < 1500  # the scene moves
            assert abs(np.nanmedian(found) - np.nanmedian(expected)) < 50
            assert frame.components[2].raw().shape == (100, 168)
        finally:
            remote.close()


def test_components_of_a_server_that_vanished_without_closing_its_connections_come_again(
    ranging: Stage,
) -> None:
    lost = threading.Event()
    remote = connect(ranging)
    with ranging.share():
        remote.connection_changed.connect(lambda state, why: state is ConnectionState.LOST and lost.set())
        remote.open()
        queue = remote.open_queue(1)
        remote.start()
        until(lambda: len(queue.get(PATIENCE).components) == 3, "all components")
    assert lost.wait(PATIENCE)
    # What a server's machine that loses its power leaves behind: connections that say nothing any more.
    dead = [
        connect_output(of, of, contact.name, contact.address, carrier.FAST_TCP, None, pytest.fail)[0]
        for of in ("/grabber/range", "/grabber/confidence")
        for contact in ranging.names.list("/grabbergui/")
        if contact.name.endswith(of)
    ]
    assert len(dead) == 2
    queue.clear()
    with ranging.share():
        until(lambda: len(queue.get(PATIENCE).components) == 3, "all components again")
        remote.close()
    for connection in dead:
        connection.close()


def test_only_the_first_component_is_received_where_one_asks_for_that(ranging: Stage) -> None:
    with ranging.share() as server:
        remote = connect(ranging, "yarp:/grabber?components=0")
        remote.open()
        try:
            queue = remote.open_queue(2)
            remote.start()
            until(lambda: len(server.places()) >= 5)
            for _ in range(20):
                assert len(queue.get(PATIENCE).components) == 1
            assert server.readers == 1
        finally:
            remote.close()


def test_a_component_that_ends_leaves_the_first_one_running(ranging: Stage) -> None:
    with ranging.share():
        remote = connect(ranging)
        remote.open()
        try:
            queue = remote.open_queue(2)
            remote.start()
            until(lambda: len(queue.get(PATIENCE).components) == 3)
            ranging.grabber.write_feature("ComponentSelector", "Range")
            ranging.grabber.write_feature("ComponentEnable", False)
            until(lambda: components_of(queue.get(PATIENCE)) == ["intensity", "confidence"])
        finally:
            remote.close()
