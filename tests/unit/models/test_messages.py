"""Messages: one for each event, with an owner and an end."""

from pathlib import Path

import pytest

from grabbergui.core.errors import LocalFileError, UsageError
from grabbergui.core.uri import SourceUri
from grabbergui.models.messages import (
    ERROR_SECONDS,
    MOST_MESSAGES,
    NOTICE_SECONDS,
    Cause,
    MessageModel,
    Severity,
    UserMessage,
)
from grabbergui.models.open_source import OpenSource
from grabbergui.models.source_messages import CurrentMessages


class Stage:
    """A model with a clock that a test turns, and two cameras."""

    def __init__(self):
        self.now = 100.0
        self.model = MessageModel(lambda: self.now)
        self.one, self.two = (OpenSource(SourceUri.parse(uri)) for uri in ("sim:", "sim:colour"))
        self.changes = []
        self.model.changed.connect(lambda: self.changes.append(1))

    def texts(self, source=None):
        return [message.text for message in self.model.shown(source)]


@pytest.fixture
def stage():
    stage = Stage()
    yield stage
    for source in (stage.one, stage.two):
        source.release()


def lost(source, count=1):
    return UserMessage("connection lost", Severity.ERROR, source, Cause.LINK, count=count)


def test_a_message_of_a_camera_is_shown_while_that_is_the_current_one(stage):
    stage.model.error("ExposureTime is locked", stage.one)
    stage.model.notice("saved")
    assert stage.texts(stage.one) == ["saved", "ExposureTime is locked"]
    assert stage.texts(stage.two) == stage.texts(None) == ["saved"]
    stage.model.forget(stage.one)
    assert stage.texts(stage.one) == ["saved"]


def test_repeated_losses_are_one_line_with_a_count_that_ends_with_the_return(stage):
    stage.model.post(lost(stage.one))
    stage.model.post(lost(stage.one, 2))
    (line,) = stage.model.shown(stage.one)
    assert line.sentence == "Connection lost  (×2)" and line.ends is None
    back = UserMessage("back after 4 s, set as before", Severity.NOTICE, stage.one, Cause.LINK, count=2)
    stage.model.post(back, seconds=10)
    assert stage.texts(stage.one) == ["back after 4 s, set as before"]
    stage.now += 10
    assert stage.texts(stage.one) == []


def test_notices_and_errors_end_after_their_time(stage):
    stage.model.notice("saved")
    stage.model.error("no such file")
    stage.now += NOTICE_SECONDS
    stage.model.expire()
    assert stage.texts() == ["no such file"] and len(stage.changes) == 3
    stage.now += ERROR_SECONDS
    assert stage.texts() == []


@pytest.mark.parametrize(
    ("failure", "text"),
    [
        (None, "Saved x.csv"),
        (PermissionError(13, "Permission denied"), "x.csv could not be written: Permission denied"),
        (OSError("no room"), "x.csv could not be written: no room"),
        (UsageError("values do not fit"), "values do not fit"),
        (LocalFileError("x.csv could not be written: no room"), "x.csv could not be written: no room"),
    ],
)
def test_a_file_is_saved_or_the_reason_is_given(stage, failure, text):
    messages = CurrentMessages(stage.model, lambda: stage.one)
    with messages.saving(Path("x.csv"), "Saved {0}"):
        if failure is not None:
            raise failure
    assert stage.texts(stage.one) == [text] and stage.texts(stage.two) == []


def test_the_same_failure_again_counts_and_stays_as_long_as_a_new_one(stage):
    stage.model.error("refused")
    stage.now += ERROR_SECONDS - 1
    stage.model.error("refused")
    (line,) = stage.model.shown(None)
    assert line.sentence == "Refused  (×2)" and line.ends == stage.now + ERROR_SECONDS
    stage.now += ERROR_SECONDS
    stage.model.error("refused")
    assert stage.model.shown(None)[0].count == 1, "the first two are over"


def test_a_dismissed_cause_stays_silent_until_it_ends(stage):
    waiting = UserMessage("is black", source=stage.one, cause=Cause.IMAGE)
    stage.model.post(waiting)
    stage.model.dismiss(waiting)
    stage.model.post(waiting)
    assert stage.texts(stage.one) == []
    stage.model.post(UserMessage("is black", source=stage.two, cause=Cause.IMAGE))
    assert stage.texts(stage.two) == ["is black"], "of another camera nobody has spoken"
    stage.model.end(stage.one, Cause.IMAGE)
    stage.model.post(waiting)
    assert stage.texts(stage.one) == ["is black"]


def test_a_dismissed_failure_is_shown_when_it_happens_again(stage):
    stage.model.error("refused")
    stage.model.dismiss(stage.model.shown(None)[0])
    stage.model.error("refused")
    assert stage.texts() == ["refused"]


def test_a_text_that_follows_its_cause_keeps_its_place(stage):
    for seconds in (3, 4):
        text = f"no frame for {seconds} s"
        stage.model.post(UserMessage(text, Severity.WARNING, stage.one, Cause.IMAGE))
        stage.model.notice("saved")
    assert stage.texts(stage.one) == ["saved", "no frame for 4 s"]
    stage.model.post(lost(stage.one))
    assert stage.texts(stage.one)[0] == "connection lost"


def test_nothing_is_announced_where_nothing_changed(stage):
    stage.model.post(lost(stage.one))
    stage.model.post(lost(stage.one))
    stage.model.end(stage.one, Cause.IMAGE)
    stage.model.expire()
    assert len(stage.changes) == 1


def test_memory_is_bounded(stage):
    for number in range(3 * MOST_MESSAGES):
        stage.model.error(f"failure {number}")
    assert len(stage.model.shown(None)) == MOST_MESSAGES


@pytest.mark.parametrize(
    ("text", "sentence"),
    [("no camera answers", "No camera answers"), ("sim: is open already", "sim: is open already"),
     ("ExposureTime is locked", "ExposureTime is locked"), ("/data/x.mp4 is full", "/data/x.mp4 is full")],
)  # fmt: skip
def test_a_message_begins_with_a_capital_unless_it_begins_with_a_name(text, sentence):
    assert UserMessage(text).sentence == sentence


def test_the_cause_comes_first_where_a_line_is_cut():
    """Before, only "…is ful…" of the most important words was visible."""
    message = UserMessage("/home/user/pictures/a.tiff could not be written: the disk is full")
    assert message.cause_first == "The disk is full: /home/user/pictures/a.tiff could not be written"
    assert UserMessage("saved").cause_first == "Saved"
    remedy = UserMessage("no camera answers: a firewall must let UDP in: sudo ufw allow 3956")
    assert remedy.cause_first == remedy.sentence
