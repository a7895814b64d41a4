"""A source that is lost: waited for, and given up after a time."""

import threading

import pytest

from fakes import ScriptedGrabber
from grabbergui.cli import arguments
from grabbergui.cli.arguments import Outage
from grabbergui.cli.awaited_source import AwaitedSource
from grabbergui.core.errors import TransportError
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.identity import DeviceInfo
from patience import PATIENCE


@pytest.fixture
def grabber():
    return ScriptedGrabber([])


def test_a_source_may_be_away_as_long_as_it_likes(grabber):
    now = [0.0]
    outage = Outage(grabber, None, clock=lambda: now[0])
    grabber.connection_changed.emit(ConnectionState.LOST, "unplugged")
    now[0] = 1e6

    outage.check()
    assert outage.present


def test_one_that_is_away_for_too_long_is_given_up(grabber):
    now = [0.0]
    outage = Outage(grabber, 60.0, clock=lambda: now[0])
    grabber.connection_changed.emit(ConnectionState.LOST, "unplugged")
    now[0] = 59.0
    grabber.connection_changed.emit(ConnectionState.LOST, "still unplugged")
    outage.check()

    now[0] = 61.0
    with pytest.raises(TransportError, match="did not come back within 60 s: still unplugged"):
        outage.check()
    outage.close()


def test_one_that_came_back_is_not(grabber):
    now = [0.0]
    outage = Outage(grabber, 60.0, clock=lambda: now[0])
    grabber.connection_changed.emit(ConnectionState.LOST, "unplugged")
    assert (outage.present, outage.waited(0.0)) == (True, 0.0)
    now[0] = 59.0
    grabber.connection_changed.emit(ConnectionState.OPEN, "plugged in")
    now[0] = 61.0

    outage.check()
    assert (outage.present, outage.waited(0.0), outage.waited(60.0)) == (False, 2.0, 1.0)


def test_whoever_waits_for_something_else_is_called(grabber):
    exceeded = threading.Event()
    outage = Outage(grabber, 0.01, on_exceeded=exceeded.set)
    grabber.connection_changed.emit(ConnectionState.LOST, "unplugged")

    assert exceeded.wait(PATIENCE)
    outage.close()


def test_a_return_after_that_call_comes_too_late(grabber):
    """The caller is about to end, which must not look like success."""
    exceeded = threading.Event()

    def come_back():
        grabber.connection_changed.emit(ConnectionState.OPEN, "plugged in")
        exceeded.set()

    outage = Outage(grabber, 0.01, on_exceeded=come_back)
    grabber.connection_changed.emit(ConnectionState.LOST, "unplugged")
    assert exceeded.wait(PATIENCE)
    with pytest.raises(TransportError, match=r"did not come back within 0\.01 s: unplugged"):
        outage.check()
    outage.close()


def test_a_source_is_closed_also_where_the_command_ends_before_it_began(monkeypatch):
    """Ctrl-C, for instance, while the names of its features are kept for the shell's completion."""
    grabber = ScriptedGrabber([])

    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(arguments.sources, "create", lambda uri: grabber)
    monkeypatch.setattr(arguments, "somebody_types", lambda: True)
    monkeypatch.setattr(arguments.Seen, "keep_features", interrupted)
    closed = []
    monkeypatch.setattr(grabber, "close", lambda: closed.append(True))
    with pytest.raises(KeyboardInterrupt), arguments.opened("sim:"):
        pass
    assert closed


@pytest.mark.parametrize(
    ("uri", "incomplete", "named"),
    [
        ("gige:7", 9, "packet_size=1400"),
        ("gige:7", 0, "firewall"),
        ("u3v:7", 9, "trigger"),
    ],
)
def test_without_a_frame_what_to_check_depends_on_what_arrived(grabber, uri, incomplete, named):
    grabber.info = DeviceInfo(uri)
    grabber.statistics = lambda: StreamStatistics(packets=231, incomplete=incomplete)
    error = AwaitedSource(grabber).no_frame(3.0)
    assert "231 packets" in str(error) and named in str(error)
