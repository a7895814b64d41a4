"""The sources found and added by the user, steady against a lost answer; small images of the open ones."""

import gc
import threading
import time
import weakref
from dataclasses import replace

import pytest

from grabbergui.core.errors import TransportError, UsageError
from grabbergui.core.identity import DeviceInfo
from grabbergui.models.open_source import LinkState
from grabbergui.models.source_opener import SourceOpener
from grabbergui.models.sources import KEEP_MISSES, GalleryModel, ListedSource, SourceListModel
from opener_bench import Source
from patience import PATIENCE, until

CAMERA = DeviceInfo("gige:GV01", vendor="Acme", model="One", serial="GV01")


class Network:
    """Answers searches as the test says; counts them."""

    def __init__(self, *infos):
        self.infos = list(infos)
        self.searches = 0

    def __call__(self, timeout):
        self.searches += 1
        if isinstance(self.infos, Exception):
            raise self.infos
        return list(self.infos)


@pytest.fixture
def listing():
    models = []

    def make(network, interval=0.01):
        models.append(SourceListModel(network, interval))
        return models[-1]

    yield make
    for model in models:
        assert model.stop()


def uris(model):
    return [line.info.uri for line in model.sources]


def test_an_ip_address_alone_is_a_gige_camera(listing):
    model = listing(Network())
    assert str(model.add(" 127.0.0.41 ")) == "gige:127.0.0.41"
    assert uris(model) == ["gige:127.0.0.41"]


def test_an_address_that_did_not_open_is_marked_until_it_does(listing):
    """It looked as healthy as any other."""
    model = listing(Network())
    model.add("gige:10.9.8.7")
    model.note_problem("gige:10.9.8.7", "it was not found")
    (line,) = model.sources
    assert line.problem == "it was not found" and line.detail.startswith("did not open")
    model.note_problem("gige:10.9.8.7", "")
    assert model.sources[0].detail.startswith("added by hand")
    model.note_problem("gige:10.9.8.7", "it was not found")
    model.remove("gige:10.9.8.7")
    model.add("gige:10.9.8.7")
    assert not model.sources[0].problem


def test_a_failure_to_open_names_the_requested_source(bench):
    refused = []
    bench.link.refused.connect(lambda *what: refused.append(what))
    bench.source.problem = TransportError("the cable is out")
    bench.link.connect_to("sim:")
    until(lambda: refused)
    assert refused == [("sim:", "the cable is out")]


def test_a_lost_camera_keeps_its_place(listing):
    other = replace(CAMERA, uri="gige:GV02", serial="GV02")
    network = Network(CAMERA, other)
    model = listing(network)
    model.start()
    until(lambda: uris(model) == ["gige:GV01", "gige:GV02"])
    model.set_open({"gige:GV01": CAMERA}, ["gige:GV01"])
    network.infos = [other]
    searches = network.searches
    until(lambda: network.searches > searches + KEEP_MISSES + 2)
    assert uris(model) == ["gige:GV01", "gige:GV02"]


def test_below_its_name_a_source_has_one_line_in_any_state():
    """It had three or four, so that few sources could be seen at a time."""
    camera = replace(CAMERA, bus="GigE Vision", address="10.0.0.3")
    states = [ListedSource(camera, connected=on, lost=lost) for on, lost in ((0, 0), (1, 0), (1, 1))]
    place = "GigE Vision · 10.0.0.3"
    details = [line.detail for line in states]
    assert details == [
        place,
        f"connected · {place}",
        f"lost, reconnecting · {place}",
    ]


def test_options_are_decoded():
    info = DeviceInfo("yarp:/grabber?nameserver=127.0.0.1%3A10871", bus="YARP", address="/grabber")
    assert "nameserver=127.0.0.1:10871" in ListedSource(info).detail


def test_found_sources_stay_listed(listing):
    network = Network(CAMERA)
    model = listing(network)
    changes = []
    model.changed.connect(changes.append)
    model.start()
    until(lambda: network.searches > 3)
    assert uris(model) == ["gige:GV01"]
    assert len(changes) == 1, "the same answer again is no change"


def test_one_lost_answer_does_not_remove_a_source_but_its_absence_does(listing):
    network = Network(CAMERA)
    model = listing(network, interval=60)
    model.note_found([CAMERA])
    for _ in range(KEEP_MISSES):
        model.note_found([])
        assert uris(model) == ["gige:GV01"]
    model.note_found([])
    assert uris(model) == []


def test_a_source_with_a_malformed_uri_does_not_disturb_the_others(listing):
    network = Network(DeviceInfo("yarp:/camera?left"), CAMERA)
    model = listing(network)
    model.start()
    until(lambda: network.searches > 1)
    model.add("sim:")
    model.set_open({"gige:GV01": CAMERA})
    assert uris(model) == ["gige:GV01", "sim:"]


def test_a_search_that_fails_does_not_end_searching(listing):
    network = Network()
    network.infos = RuntimeError("broken finder")
    model = listing(network)
    model.start()
    until(lambda: network.searches > 1)
    network.infos = [CAMERA]
    until(lambda: uris(model) == ["gige:GV01"])


def test_refresh_searches_at_once(listing):
    network = Network()
    model = listing(network, interval=60)
    model.start()
    until(lambda: network.searches == 1)
    model.refresh()
    until(lambda: network.searches == 2)


def test_a_source_added_by_user_stays_until_removed_and_is_not_listed_twice(listing):
    model = listing(Network())
    assert str(model.add("gige://10.0.0.7")) == "gige:10.0.0.7"
    assert [(line.info.uri, line.manual) for line in model.sources] == [("gige:10.0.0.7", True)]
    model.note_found([DeviceInfo("gige:10.0.0.7", model="Found")])
    assert [(line.info.uri, line.manual) for line in model.sources] == [("gige:10.0.0.7", False)]
    model.remove("gige:10.0.0.7")
    assert uris(model) == ["gige:10.0.0.7"]


@pytest.mark.parametrize(
    ("typed", "says"),
    [
        ("192.168.0", "write its kind first"),
        ("foo:bar", "of no known kind"),
        ("sim:?pixelformat=Mono8", "did you mean pixel_format"),
        ("v4l2:?fps=3", "sources have no options"),
    ],
)
def test_a_malformed_address_is_refused(listing, typed, says):
    model = listing(Network())
    with pytest.raises(UsageError, match=says):
        model.add(typed)
    assert model.sources == ()


def test_stopping_ends_the_thread_at_once(listing):
    network = Network()
    model = listing(network, interval=60)
    model.start()
    until(lambda: network.searches == 1)
    begun = time.monotonic()
    assert model.stop()
    assert time.monotonic() - begun < PATIENCE, "it did not wait for the next search"
    assert not any(thread.name == "discovery" for thread in threading.enumerate())


def test_an_open_source_is_listed_and_marked_though_no_search_finds_it(listing):
    model = listing(Network())
    model.set_open({"yarp:/grabber": DeviceInfo("yarp:/grabber", bus="YARP")})
    assert [(line.info.bus, line.connected, line.manual) for line in model.sources] == [("YARP", True, False)]
    model.set_open({})
    assert model.sources == ()


def test_a_typed_address_and_the_camera_found_there_are_one_line(listing):
    network = Network()
    model = listing(network)
    model.add("gige:192.168.0.10")
    model.set_open({"gige:192.168.0.10": CAMERA})
    (line,) = model.sources
    assert (line.info, line.manual, line.connected) == (CAMERA, True, True)
    network.infos = [CAMERA]
    model.start()
    until(lambda: not model.sources[0].manual)
    assert [(line.info, line.connected) for line in model.sources] == [(CAMERA, True)]
    model.set_open({})
    assert not model.sources[0].connected
    assert model.added_by_user == ["gige:192.168.0.10"]


FOUND = DeviceInfo(
    "gige:7", "Acme", "One", "7", "GigE Vision", "10.0.0.7", "left", hardware_id="00:30:53:0a:0b:0c"
)
TWIN = replace(FOUND, uri="gige:10.0.0.8", address="10.0.0.8", hardware_id="00:30:53:0a:0b:0d")


@pytest.mark.parametrize("typed", ["gige:10.0.0.7", "gige:7", "gige:left", "gige:00:30:53:0a:0b:0c"])
def test_a_camera_typed_by_any_of_its_names_and_then_found_is_one_line(listing, typed):
    model = listing(Network())
    model.add(typed)
    model.note_found([FOUND])
    assert uris(model) == [FOUND.uri]
    model.set_open({typed: replace(FOUND, uri=typed)})
    (line,) = model.sources
    assert (line.info.uri, line.connected) == (typed, True), "it is open under the name that was typed"
    model.set_open({})
    assert uris(model) == [FOUND.uri]


def test_a_typed_camera_with_options_keeps_them_in_its_one_line_and_can_be_forgotten(listing):
    model = listing(Network())
    model.add("gige:10.0.0.7?packet_size=1500")
    model.note_found([FOUND])
    (line,) = model.sources
    assert (line.info.uri, line.info.model, line.manual) == ("gige:10.0.0.7?packet_size=1500", "One", True)
    model.remove(line.info.uri)
    assert uris(model) == [FOUND.uri] and model.added_by_user == []


def test_two_cameras_of_one_serial_number_are_two_lines_whichever_is_open(listing):
    model = listing(Network())
    model.note_found([replace(FOUND, uri="gige:10.0.0.7"), TWIN])
    model.set_open({"gige:10.0.0.8": TWIN})
    assert [(line.info.uri, line.connected) for line in model.sources] == [
        ("gige:10.0.0.7", False),
        ("gige:10.0.0.8", True),
    ]


def test_a_simulated_camera_with_options_is_another_camera(listing):
    model = listing(Network())
    model.note_found([DeviceInfo("sim:", model="Simulated camera", serial="SIM001")])
    model.add("sim:?width=640")
    assert uris(model) == ["sim:", "sim:?width=640"]


def test_a_typed_source_is_forgotten_under_either_name(listing):
    model = listing(Network())
    model.add("gige:192.168.0.10")
    model.set_open({"gige:192.168.0.10": CAMERA})
    model.set_open({})
    model.remove(CAMERA.uri)
    assert model.sources == () and model.added_by_user == []


def test_a_camera_that_is_lost_stays_listed_and_is_marked(listing):
    model = listing(Network())
    model.set_open({"gige:192.168.0.10": CAMERA})
    model.set_open({"gige:192.168.0.10": CAMERA}, lost=["gige:192.168.0.10"])
    assert [(line.info, line.connected, line.lost) for line in model.sources] == [(CAMERA, True, True)]
    model.set_open({"gige:192.168.0.10": CAMERA})
    assert not model.sources[0].lost


def displays():
    return [thread for thread in threading.enumerate() if thread.name == "display"]


@pytest.fixture
def open_sources():
    connection = SourceOpener()
    gallery = GalleryModel(connection.open_sources)

    def open_them(*uris):
        for uri in uris:
            connection.open_additional(uri)
        until(lambda: all(source.state is LinkState.STREAMING for source in connection.open_sources.all))
        return connection, gallery

    yield open_them
    connection.open_sources.close_all()
    assert gallery.close(5) and connection.open_sources.wait_closed(PATIENCE)
    assert not displays()


SMALL = "?width=64&height=48"


def test_one_source_has_no_tile(open_sources):
    _, gallery = open_sources("sim:" + SMALL)
    assert gallery.tiles == () and not displays()


def test_each_of_several_sources_has_an_image_of_its_own(open_sources):
    connection, gallery = open_sources("sim:" + SMALL, "sim:colour" + SMALL)
    assert [tile.source for tile in gallery.tiles] == list(connection.open_sources.all)
    shown = {}

    def seen():
        for tile in gallery.tiles:
            if (image := tile.image.take()) is not None:
                shown[str(tile.source.uri)] = image.image.pixels.ndim
        return len(shown) == 2

    until(seen)
    assert shown == {"sim:" + SMALL: 2, "sim:colour" + SMALL: 3}, "one in grey, one in colour"


def test_one_camera_over_two_networks_has_two_names(bench):
    remote = replace(FOUND, user_name="left eye")
    for uri, bus in (("yarp:/left", "YARP"), ("ros2:/left", "ROS 2"), ("ros2:/eye", "ROS 2")):
        bench.others[uri] = source = Source()
        source.info = replace(remote, uri=uri, bus=bus, address=uri.partition(":")[2])
    bench.link.connect_to("yarp:/left")
    bench.until(LinkState.STREAMING)
    over_yarp = bench.sources.current
    assert over_yarp.names == ("left eye", "left eye", "left eye")
    for uri in ("ros2:/left", "ros2:/eye"):
        bench.link.open_additional(uri)
    until(lambda: all(source.state is LinkState.STREAMING for source in bench.sources.all))
    assert [source.title for source in bench.sources.all] == [
        "left eye · YARP",
        "left eye · ros2:/left",
        "left eye · /eye",
    ]
    bench.sources.close(bench.sources.all[1])
    bench.sources.close(bench.sources.all[1])
    until(lambda: over_yarp.title == "left eye")


def test_a_late_signal_with_older_sources_removes_no_tile(open_sources):
    connection, gallery = open_sources("sim:" + SMALL, "sim:colour" + SMALL)
    connection.open_sources.changed.emit(connection.open_sources.all[:1])
    assert [tile.source for tile in gallery.tiles] == list(connection.open_sources.all)


def test_tiles_convert_at_the_pace_of_their_views(open_sources):
    _, gallery = open_sources("sim:?width=64&height=48&fps=200", "sim:colour" + SMALL)
    image = gallery.tiles[0].image
    until(lambda: image.received > 50)
    assert image.converted <= 5, "nobody takes any"


def test_a_source_that_is_closed_leaves_no_thread_and_no_memory(open_sources):
    connection, gallery = open_sources("sim:" + SMALL, "sim:colour" + SMALL, "sim:scene")
    last = connection.open_sources.all[-1]
    gone = [weakref.ref(last), weakref.ref(last.grabber), weakref.ref(gallery.tiles[-1].image)]
    connection.open_sources.close(last)
    del last
    assert connection.open_sources.wait_closed(PATIENCE)
    until(lambda: len(displays()) == 2)
    assert len(gallery.tiles) == 2

    def released():
        gc.collect()
        return not any(ref() for ref in gone)

    until(released)


def test_with_one_source_left_the_tiles_go(open_sources):
    connection, gallery = open_sources("sim:" + SMALL, "sim:colour" + SMALL)
    connection.open_sources.close_current()
    assert gallery.tiles == () and str(connection.open_sources.current.uri).startswith("sim:colour")
    until(lambda: not displays())
