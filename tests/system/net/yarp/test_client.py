"""A remote camera as a source: ours with its whole tree, and one that knows YARP's numbers only."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Iterator

import pytest

from grabber_stage import Stage, connect, pretend_to_be_yarps_own
from grabbergui.core.errors import (
    FeatureAccessError,
    FeatureError,
    FeatureNotFoundError,
    FeatureValueError,
    SourceNotFoundError,
    SourceUnavailableError,
    TransportError,
    UsageError,
)
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.core.uri import SourceUri
from grabbergui.net import tree
from grabbergui.net.yarp import client, grabber_link
from grabbergui.net.yarp.client import YarpGrabber
from grabbergui.net.yarp.os import name_client
from patience import PATIENCE, attempts, until


@pytest.fixture(params=["ours", "3.x", "4.0"])
def remote(
    scene: Stage, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> Iterator[FrameGrabber]:
    """An open client of a server that is ours, or pretends to be YARP's own of one kind."""
    monkeypatch.setattr(grabber_link, "TIMEOUT", PATIENCE)  # others may have the machine's cores
    if request.param != "ours":
        pretend_to_be_yarps_own(monkeypatch, request.param)
    with scene.share():
        grabber = connect(scene)
        grabber.open()
        yield grabber
        grabber.close()


def test_features_are_read_and_written(scene: Stage, remote: FrameGrabber) -> None:
    local = scene.grabber.feature("ExposureTime")
    exposure = remote.feature("ExposureTime")
    assert (exposure.value, exposure.minimum, exposure.maximum) == (local.value, local.minimum, local.maximum)
    assert remote.write_feature("ExposureTime", "2500").value == 2500.0
    assert scene.grabber.feature("ExposureTime").value == 2500.0
    remote.write_feature("GainAuto", "Continuous")
    assert remote.write_feature("Gain", 3.0).value == 3.0  # switches the automatic mode off
    assert scene.grabber.feature("GainAuto").value == "Off"
    with pytest.raises(FeatureValueError, match="allowed:"):
        remote.write_feature("ExposureTime", -1)
    with pytest.raises(FeatureNotFoundError, match="did you mean Gain"):
        remote.feature("Gian")
    assert remote.info.model.endswith("Simulated camera")


def test_images_and_their_counters(scene: Stage, remote: FrameGrabber) -> None:
    queue, begun = remote.open_queue(4), time.time()
    remote.start()
    remote.start()
    first, second = queue.get(PATIENCE), queue.get(PATIENCE)
    assert (first.width, first.height, first.rgb().shape) == (168, 100, (100, 168, 3))
    assert second.frame_id > first.frame_id
    assert begun - 5 < second.timestamp_ns / 1e9 < time.time() + 5
    until(lambda: remote.statistics().frame_rate > 5, "a frame rate")
    remote.stop()
    assert not remote.streaming
    assert remote.statistics().frames >= 2
    remote.start()
    assert queue.get(PATIENCE).complete


def test_what_others_change_is_seen_within_a_second(scene: Stage, remote: FrameGrabber) -> None:
    seen: set[str] = set()
    remote.features_changed.connect(lambda names: seen.update(names))
    values = itertools.count(4)
    for _ in ("before the client has looked at anything", "after"):
        for watch in attempts(1.0):
            seen.clear()
            with watch:
                scene.grabber.write_feature("Gain", next(values))
                until(lambda: "Gain" in seen, "the change")


def test_a_server_selects_and_writes_in_one_step(coloured: Stage) -> None:
    """What a client writes under a selector moves nobody's selector, also with many at work."""
    red, blue = (SettingKey("BalanceRatio", (("BalanceRatioSelector", entry),)) for entry in ("Red", "Blue"))
    wrong = []
    with coloured.share():
        coloured.grabber.write_feature("BalanceRatioSelector", "Green")
        remotes = [connect(coloured), connect(coloured)]
        for remote in remotes:
            remote.open()

        def write(remote: FrameGrabber, key: SettingKey, base: float) -> None:
            for number in range(20):
                value = base + number / 100
                result = remote.write_setting(key, value)
                if abs(float(result.feature.value or 0) - value) > 1e-3 or result.written[-1].key != key:
                    wrong.append(result)

        work = [
            threading.Thread(target=write, args=arguments)
            for arguments in ((remotes[0], red, 1.0), (remotes[1], blue, 2.0))
        ]
        for thread in work:
            thread.start()
        seen = {coloured.grabber.feature("BalanceRatioSelector").value for _ in range(100)}
        for thread in work:
            thread.join()
        for remote in remotes:
            remote.close()
    assert wrong == [] and seen == {"Green"}


def test_a_write_returns_its_companions_in_the_same_reply(coloured: Stage) -> None:
    coloured.grabber.write_feature("ExposureAuto", "Continuous")
    with coloured.share():
        remote = connect(coloured)
        remote.open()
        result = remote.write_setting(SettingKey("ExposureTime"), 5000)
        remote.close()

    assert [(feature.name, feature.value) for feature in result.also_changed] == [("ExposureAuto", "Off")]


def test_a_server_of_an_older_version_is_asked_step_by_step(
    coloured: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tree, "VERSION", 1)
    blue = SettingKey("BalanceRatio", (("BalanceRatioSelector", "Blue"),))
    with coloured.share():
        coloured.grabber.write_feature("BalanceRatioSelector", "Green")
        remote = connect(coloured)
        remote.open()
        assert remote.write_setting(blue, 1.75).feature.value == pytest.approx(1.75)
        assert remote.feature("BalanceRatioSelector").value == "Green"
        assert coloured.grabber.read_setting(blue).value == pytest.approx(1.75)
        remote.close()


def test_ours_gives_several_features_by_one_request(scene: Stage) -> None:
    names = ["Gain", "Width", "PixelFormat"]
    with scene.share():
        remote = connect(scene)
        remote.open()
        assert isinstance(remote, YarpGrabber) and remote._link
        ask, asked = remote._link._rpc.call, []
        remote._link._rpc.call = lambda *request: asked.append(request) or ask(*request)  # type: ignore[method-assign, func-returns-value]
        assert remote.reads_at_once >= len(names)
        assert remote.read_features(names) == [scene.grabber.offered(scene.grabber.feature(n)) for n in names]
        features = [request for request in asked if "feature" in request[0]]
        assert len(features) == 1
        with pytest.raises(FeatureNotFoundError):
            remote.read_features(["Gain", "Gian"])
        remote.close()


def test_a_server_of_yarps_own_is_asked_for_one_at_a_time(remote: FrameGrabber) -> None:
    assert (remote.reads_at_once > 1) == bool(remote.info.serial)  # only ours reports one
    assert [feature.name for feature in remote.read_features(["Gain", "ExposureTime"])] == [
        "Gain",
        "ExposureTime",
    ]


def test_ours_has_every_feature(scene: Stage) -> None:
    with scene.share():
        remote = connect(scene)
        remote.open(Access.MONITOR)
        assert remote.feature_tree() == scene.grabber.feature_tree()
        assert remote.feature("PixelFormat").entries == scene.grabber.feature("PixelFormat").entries
        with pytest.raises(FeatureAccessError, match="reading only"):
            remote.write_feature("Gain", 1)
        remote.close()


def test_a_command_is_executed_by_the_served_camera_and_refused_with_its_reason(scene: Stage) -> None:
    with scene.share():
        remote = connect(scene)
        remote.open()
        remote.execute("TimestampLatch")
        latched = remote.feature("TimestampLatchValue").value
        remote.execute("TimestampLatch")
        assert remote.feature("TimestampLatchValue").value != latched
        with pytest.raises(FeatureNotFoundError):
            remote.execute("Launch")
        with pytest.raises(FeatureError, match="UserSetLoad"):  # locked while streaming
            remote.execute("UserSetLoad")
        remote.close()


def test_a_missing_port_or_name_server_is_reported(scene: Stage) -> None:
    remote = connect(scene, "yarp:/nobody")
    with pytest.raises(SourceNotFoundError, match="/nobody"):
        remote.open()
    with pytest.raises(TransportError, match="not open"):
        remote.feature_tree()
    remote.close()
    gone = client.create(SourceUri("yarp", "/grabber", {"nameserver": "127.0.0.1:1"}))
    with pytest.raises(SourceUnavailableError, match="no YARP name server"):
        gone.open()


def test_a_uri_with_an_unknown_port_name_or_option_is_refused() -> None:
    assert client.create(SourceUri.parse("yarp:")).info.address == "/grabber"
    assert client.create(SourceUri.parse("yarp:/grabber/")).info.address == "/grabber", "as `serve` names it"
    for bad in ("yarp:grabber", "yarp:/g?speed=3"):
        with pytest.raises(UsageError, match=r"yarp:|begin with /"):
            client.create(SourceUri.parse(bad))


@pytest.mark.parametrize("carrier", ["pigeon", "shmem", "text", "text_ack", ""])
def test_a_carrier_without_images_is_refused_with_those_that_have_them(carrier: str) -> None:
    wanted = f"images arrive over tcp, fast_tcp, udp, mcast, mjpeg, unix_stream, not over '{carrier}'"
    with pytest.raises(UsageError, match=wanted):
        client.create(SourceUri.parse(f"yarp:/g?carrier={carrier}"))


def test_plug_ins_run_at_the_other_end_except_bayer() -> None:
    for lacking in ("tcp+recv.portmonitor", "mjpeg+recv.bayer"):
        with pytest.raises(UsageError, match=r"no such plug-in; choose a carrier without \+recv\."):
            client.create(SourceUri.parse(f"yarp:/g?carrier={lacking}"))
    for carrier in ("tcp+send.portmonitor+type.lua", "tcp+recv.bayer+order.bggr"):
        client.create(SourceUri.parse(f"yarp:/g?carrier={carrier}"))


def test_the_name_server_is_no_camera(scene: Stage) -> None:
    with pytest.raises(TransportError, match="/root is the name server, not a camera"):
        connect(scene, "yarp:/root").open()


def test_discovery_lists_the_served_cameras_of_the_name_server(
    scene: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(name_client, "name_server", lambda: None)
    assert client.discover(1.0) == []
    monkeypatch.setattr(name_client, "name_server", lambda: scene.name_server.contact)
    assert client.discover(1.0) == []
    with scene.share("/left/grabber"), scene.share("/right/grabber"):
        found = client.discover(2.0)
    assert [info.uri for info in found] == ["yarp:/left/grabber", "yarp:/right/grabber"]
    assert {info.model for info in found} == {scene.grabber.info.model}


def test_a_listed_port_with_a_question_mark_can_be_opened(
    scene: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(name_client, "name_server", lambda: scene.name_server.contact)
    with scene.share("/camera?left"):
        (found,) = client.discover(2.0)
        assert found.uri == "yarp:/camera%3Fleft"
        remote = client.create(SourceUri.parse(found.uri))
        remote.open()
        assert (remote.info.uri, remote.info.address) == (found.uri, "/camera?left")
        remote.close()
