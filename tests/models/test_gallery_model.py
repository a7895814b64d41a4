"""Small pictures of all open sources: made while there are several, gone with their source."""

import gc
import threading
import weakref

import pytest

from grabbergui.models.connection import Connection
from grabbergui.models.gallery import GalleryModel
from grabbergui.models.open_source import LinkState
from patience import PATIENCE, until


def displays():
    return [thread for thread in threading.enumerate() if thread.name == "display"]


@pytest.fixture
def open_sources():
    connection = Connection()
    gallery = GalleryModel(connection)

    def open_them(*uris):
        for uri in uris:
            connection.open_additional(uri)
        until(lambda: all(source.state is LinkState.STREAMING for source in connection.sources))
        return connection, gallery

    yield open_them
    connection.close_all()
    assert gallery.close(5) and connection.wait_closed(PATIENCE)
    assert not displays()


SMALL = "?width=64&height=48"


def test_one_source_has_no_tile(open_sources):
    _, gallery = open_sources("sim:" + SMALL)
    assert gallery.tiles == () and not displays()


def test_each_of_several_sources_has_an_image_of_its_own(open_sources):
    connection, gallery = open_sources("sim:" + SMALL, "sim:colour" + SMALL)
    assert [tile.source for tile in gallery.tiles] == list(connection.sources)
    shown = {}

    def seen():
        for tile in gallery.tiles:
            if (picture := tile.picture.take()) is not None:
                shown[str(tile.source.uri)] = picture.image.pixels.ndim
        return len(shown) == 2

    until(seen)
    assert shown == {"sim:" + SMALL: 2, "sim:colour" + SMALL: 3}, "one in grey, one in colour"


def test_nothing_is_converted_faster_than_it_is_looked_at(open_sources):
    _, gallery = open_sources("sim:?width=64&height=48&fps=200", "sim:colour" + SMALL)
    picture = gallery.tiles[0].picture
    until(lambda: picture.received > 50)
    assert picture.converted <= 5, "nobody takes any"


def test_a_source_that_is_closed_leaves_no_thread_and_no_memory(open_sources):
    connection, gallery = open_sources("sim:" + SMALL, "sim:colour" + SMALL, "sim:scene")
    last = connection.sources[-1]
    gone = [weakref.ref(last), weakref.ref(last.grabber), weakref.ref(gallery.tiles[-1].picture)]
    connection.close(last)
    del last
    assert connection.wait_closed(PATIENCE)
    until(lambda: len(displays()) == 2)
    assert len(gallery.tiles) == 2

    def released():
        gc.collect()
        return not any(ref() for ref in gone)

    until(released)


def test_with_one_source_left_the_tiles_go(open_sources):
    connection, gallery = open_sources("sim:" + SMALL, "sim:colour" + SMALL)
    connection.disconnect()
    assert gallery.tiles == () and str(connection.source.uri).startswith("sim:colour")
    until(lambda: not displays())
