"""The whole GenICam tree over the wire, and its change log."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable
from contextlib import closing, suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from fakes import ScriptedGrabber
from grabbergui import sources
from grabbergui.core import errors
from grabbergui.core.errors import (
    DeviceStatusError,
    FeatureValueError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
    UsageError,
)
from grabbergui.core.features import (
    AccessMode,
    Category,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    Representation,
    Visibility,
)
from grabbergui.core.identity import DeviceInfo
from grabbergui.net import tree
from grabbergui.net.tree import ChangeLog, TreeService, error_of
from grabbergui.net.yarp import grabber_values
from grabbergui.net.yarp.grabber_service import GrabberService
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.values import Vocab
from patience import PATIENCE

FULL = Feature(
    name="Gain",
    kind=FeatureKind.FLOAT,
    display_name="Gain (dB)",
    tooltip="Amplification",
    description="Of the analogue signal",
    visibility=Visibility.GURU,
    category="AnalogControl",
    streamable=True,
    selectors=("GainSelector",),
    access=AccessMode.READ_WRITE,
    value=0.1,
    minimum=-(2**63),
    maximum=2**63 - 1,
    increment=1e-9,
    unit="dB",
    representation=Representation.LOGARITHMIC,
    entries=(EnumEntry("One", "Eins", "µ", False), EnumEntry("Two")),
    auto="GainAuto",
    maximum_length=12,
    pauses_stream=True,
    problem="näh",
)
TREE = Category(
    "Root",
    members=(
        Category(
            "AnalogControl",
            "Analog Control",
            "What is amplified",
            Visibility.EXPERT,
            (FeatureDescription(name="Gain", kind=FeatureKind.FLOAT), Category("Empty")),
        ),
        FeatureDescription(name="Width", kind=FeatureKind.INTEGER, selectors=("A", "B")),
    ),
)


def carried(result: object) -> Any:
    """Return a result as the other end reads it from the wire's bytes."""
    return grabber_values.read_tree_reply(Bottle.decode(grabber_values.tree_success(result).encode()))


def test_features_and_trees_come_back_whole() -> None:
    assert tree.read_feature(carried(FULL)) == FULL
    assert tree.read_category(carried(TREE)) == TREE
    info = DeviceInfo("gige:1", vendor="Acme", serial="7")
    assert tree.read_info(carried(info)) == info


@pytest.mark.parametrize("value", [True, 2**63 - 1, 0.1, "ä", None])
def test_values_keep_their_type(value: object) -> None:
    feature = Feature(name="X", kind=FeatureKind.STRING, access=AccessMode.READ_ONLY, value=value)  # type: ignore[arg-type]
    again = tree.read_feature(carried(feature))
    assert (again.value, type(again.value)) == (value, type(value))


def test_a_number_that_json_does_not_have_is_no_value() -> None:
    feature = Feature(
        name="X",
        kind=FeatureKind.FLOAT,
        access=AccessMode.READ_ONLY,
        value=float("inf"),
        maximum=float("inf"),
    )
    again = tree.read_feature(carried(feature))
    assert again.value is None and again.maximum is None


def test_errors_are_raised_at_the_other_end() -> None:
    for error in (FeatureValueError("Gain=99: no", "Gain"), TransportError("gone"), GrabberError("?")):
        reply = Bottle.decode(grabber_values.tree_failure(error).encode())
        with pytest.raises(type(error), match=str(error)[:4].replace("?", "[?]")) as caught:
            grabber_values.read_tree_reply(reply)
        assert type(caught.value) is type(error)
        assert getattr(caught.value, "feature", "") == getattr(error, "feature", "")
    # One whose constructor needs more than crosses the wire comes as the base.
    with pytest.raises(GrabberError, match="refused"):
        grabber_values.read_tree_reply(grabber_values.tree_failure(DeviceStatusError("refused", 0x8006)))
    with pytest.raises(GrabberError, match="text"):
        grabber_values.read_tree_reply([grabber_values.TREE_WORD, "error", "SystemExit", "text", ""])


@every_case("name", [name for name in vars(errors) if name.endswith("Error")])
def test_every_error_of_ours_can_be_raised_at_the_other_end(name: str) -> None:
    raised = error_of(name, "it failed", "Gain")
    assert str(raised) == "it failed"
    assert isinstance(raised, GrabberError)


def test_fields_of_a_newer_peer_are_ignored() -> None:
    data = json.loads(json.dumps(carried(FULL))) | {"colour": "red"}
    assert tree.read_feature(data) == FULL


@every_case(
    "data",
    [
        *(None, 3, [], {}, {"name": "X"}, {"name": 5, "kind": "float", "access": "RW"}),
        {"name": "X", "kind": "vector", "access": "RW"},
        {"name": "X", "kind": "float", "access": "RW", "value": [1]},
        {"name": "X", "kind": "float", "access": "RW", "entries": 3},
        {"name": "X", "kind": "float", "access": "RW", "entries": [3]},
        {"name": "X", "kind": "float", "access": "RW", "selectors": 3},
        {"name": "X", "kind": "float", "access": "RW", "minimum": "0"},
        {"name": "X", "kind": "float", "access": "RW", "increment": [1]},
        {"name": "X", "kind": "float", "access": "RW", "unit": 5},
        {"name": "X", "kind": "float", "access": "RW", "display_name": None},
        {"name": "X", "kind": "float", "access": "RW", "auto": 1},
        {"name": "X", "kind": "float", "access": "RW", "pauses_stream": "yes"},
        {"name": "X", "kind": "integer", "access": "RW", "value": math.inf},
        {"name": "X", "kind": "integer", "access": "RW", "value": 1, "maximum": math.nan},
        {"name": "X", "kind": "string", "access": "RW", "maximum_length": 1.5},
        {"name": "X", "kind": "enumeration", "access": "RW", "entries": [{"name": "A", "tooltip": 1}]},
    ],
)
def test_malformed_features_are_refused(data: object) -> None:
    with pytest.raises(RemoteProtocolError):
        tree.read_feature(data)


def test_endless_categories_are_refused() -> None:
    data: dict[str, object] = {"name": "X"}
    for _ in range(100):
        data = {"name": "X", "members": [data]}
    with pytest.raises(RemoteProtocolError, match="nested"):
        tree.read_category(data)


def test_other_servers_do_not_understand() -> None:
    assert not grabber_values.tree_understood([Vocab("nak")])
    assert not grabber_values.tree_understood([Vocab("fail")])
    assert grabber_values.tree_understood(grabber_values.tree_success(None))
    for reply in (
        [],
        [Vocab("nak")],
        ["genicam"],
        ["genicam", "ok"],
        ["genicam", "ok", "{"],
        ["genicam", "ok", 3],
    ):
        with pytest.raises(RemoteProtocolError):
            grabber_values.read_tree_reply(reply)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["name", "kind", "members", "entries", "access", "value"]), inner)
    ),
    max_leaves=10,
)


@given(json_values)
def test_json_of_any_shape_is_read_or_refused(data: object) -> None:
    for read in (tree.read_feature, tree.read_category, tree.read_info):
        with suppress(RemoteProtocolError):
            text = tree.dumps(read(data))
            assert tree.dumps(read(tree.loads(text))) == text


@pytest.fixture
def grabber() -> ScriptedGrabber:
    return ScriptedGrabber([FULL])


def test_changes_since_a_revision(grabber: ScriptedGrabber) -> None:
    log = ChangeLog(grabber)
    start, names = log.since(0)
    assert names is None  # nobody listened before
    assert log.since(start) == (start, [])
    grabber.features_changed.emit(frozenset({"Gain"}))
    grabber.features_changed.emit(frozenset({"Gain", "Width"}))
    assert log.since(start) == (start + 2, ["Gain", "Width"])
    assert log.since(start + 2) == (start + 2, [])
    assert log.since(start + 3)[1] is None  # from another life of the server
    log.close()
    assert not len(grabber.features_changed)


def test_too_old_a_revision_may_have_missed_anything(grabber: ScriptedGrabber) -> None:
    log = ChangeLog(grabber)
    start, _ = log.since(0)
    for _ in range(tree.MEMORY + 1):
        grabber.features_changed.emit(frozenset({"Gain"}))
    assert log.since(start)[1] is None
    assert log.since(start + 1)[1] == ["Gain"]
    log.close()


@pytest.mark.parametrize("revision", ["", "-1", "one", "9" * 5000])
def test_a_malformed_revision_is_refused(grabber: ScriptedGrabber, revision: str) -> None:
    with pytest.raises(UsageError, match="is no whole number"):
        TreeService(grabber).perform("changes", revision)


def test_the_log_listens_only_while_asked(grabber: ScriptedGrabber, monkeypatch: pytest.MonkeyPatch) -> None:
    log = ChangeLog(grabber)
    assert not len(grabber.features_changed)
    start, _ = log.since(0)
    assert len(grabber.features_changed) == 1
    monkeypatch.setattr(tree, "IDLE", -1.0)
    grabber.features_changed.emit(frozenset({"Gain"}))
    assert not len(grabber.features_changed)
    assert log.since(start)[1] is None
    log.close()


class _LockWithGap:
    """A lock that runs `between` once, right after its next release."""

    def __init__(self, between: Callable[[], object]) -> None:
        self._lock = threading.Lock()
        self._between: Callable[[], object] | None = between

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()
        between, self._between = self._between, None
        if between is not None:
            between()


def test_a_request_while_the_log_becomes_idle_keeps_it_listening(
    grabber: ScriptedGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = ChangeLog(grabber)
    log.since(0)
    answers: list[int] = []
    monkeypatch.setattr(tree, "IDLE", -1.0)

    def request() -> None:
        monkeypatch.setattr(tree, "IDLE", PATIENCE)
        answers.append(log.since(0)[0])

    monkeypatch.setattr(log, "_lock", _LockWithGap(request))
    grabber.features_changed.emit(frozenset({"Gain"}))
    grabber.features_changed.emit(frozenset({"Width"}))

    assert log.since(answers[0])[1] == ["Width"]
    log.close()
    assert not len(grabber.features_changed)


@pytest.mark.parametrize("verb", ["write", "set"])
def test_true_is_written_to_a_switch_and_to_no_number(verb: str) -> None:
    """YARP reads it as the vocab 1."""
    with closing(sources.create("sim:?width=64&height=48")) as camera:
        camera.open()
        service = GrabberService(camera)

        def ask(line: str) -> list[Any]:
            return list(Bottle.decode(b"".join(service.answer(Bottle.from_text(line)))))

        assert ask(f"genicam {verb} Gain true")[1:3] == ["error", "FeatureValueError"]
        assert ask(f"genicam {verb} Width true")[1:3] == ["error", "FeatureValueError"]
        assert ask(f"genicam {verb} Gain (1)")[1:3] == ["error", "RemoteProtocolError"]
        assert camera.feature("Gain").value == 0
        assert ask(f"genicam {verb} ReverseX true")[1] == "ok" and camera.feature("ReverseX").value is True
        assert ask(f"genicam {verb} Gain 1")[1] == "ok" and camera.feature("Gain").value == 1
        service.close()
