"""Stream channels are shown as components; a polarised sensor is recognised by the names its maker gives."""

from types import SimpleNamespace

import numpy as np
import pytest
from psygnal import Signal

from fakes import ScriptedGrabber
from grabbergui.core.component import ComponentKind
from grabbergui.core.errors import FeatureAccessError
from grabbergui.core.features import AccessMode, Category, EnumEntry, Feature, FeatureDescription, FeatureKind
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_code, by_name
from grabbergui.core.scan3d import may_change
from grabbergui.models.image.camera_watch import CameraWatch, is_polarised
from grabbergui.models.image.components import labels
from grabbergui.models.image.quantities import is_mosaic
from grabbergui.models.image.stream_channels import CHANNEL_SILENCE, StreamChannels


def frame(channel, number):
    pixels = np.full(16, 10 * channel + number, np.uint8)
    return Frame(pixels, 4, 4, by_name("Mono8"), number, stream_channel=channel)


def test_frames_of_a_single_channel_pass_unchanged():
    channels = StreamChannels()
    first, second = frame(0, 1), frame(0, 2)
    assert channels.merged(first, 0.0) is first and channels.merged(second, 0.1) is second
    other = frame(3, 1)
    assert StreamChannels().merged(other, 0.0) is other


def test_the_newest_of_each_channel_are_the_components():
    channels = StreamChannels()
    channels.merged(frame(1, 1), 0.0)
    both = channels.merged(frame(0, 1), 0.1)
    assert labels(both) == ("Intensity, source 0", "Intensity, source 1")
    assert both.stream_channel == 0 and both.rgb()[0, 0, 0] == 1
    later = channels.merged(frame(1, 5), 0.2)
    assert [int(part.raw()[0, 0]) for part in later.components] == [1, 15]
    assert [part.kind for part in later.components] == [ComponentKind.INTENSITY] * 2


def test_a_channel_that_ended_is_not_shown_any_more():
    channels = StreamChannels()
    channels.merged(frame(1, 1), 0.0)
    assert len(channels.merged(frame(0, 1), 0.1).components) == 2
    alone = frame(0, 2)
    assert channels.merged(alone, CHANNEL_SILENCE + 0.05) is alone
    channels.merged(frame(1, 2), CHANNEL_SILENCE + 0.1)
    channels.clear()
    alone = frame(0, 3)
    assert channels.merged(alone, CHANNEL_SILENCE + 0.2) is alone


class Camera:
    """Has PixelFormat with these entries, and these other features."""

    def __init__(self, entries=(), features=(), readable=True):
        self._entries, self._names, self._readable = entries, ("PixelFormat", *features), readable

    def feature_tree(self):
        members = (FeatureDescription(name=name, kind=FeatureKind.ENUMERATION) for name in self._names)
        return Category("Root", members=tuple(members))

    def has_feature(self, name):
        return name in self._names

    def feature(self, name):
        if not self._readable:
            raise FeatureAccessError("PixelFormat", "cannot be read")
        entries = tuple(EnumEntry(entry) for entry in self._entries)
        return Feature(name=name, kind=FeatureKind.ENUMERATION, access=AccessMode.READ_WRITE, entries=entries)


@pytest.mark.parametrize(
    ("camera", "polarised"),
    [
        (Camera(["Mono8", "PolarizedAngles_0d_45d_90d_135d_Mono8"]), True),
        (Camera(["PolarizeMono12p"]), True),
        (Camera(["Mono8"], ["PolarizationMode"]), True),
        (Camera(["Mono8", "BayerRG8"], ["PolarityInverter", "LinePolarity"]), False),
        (Camera(["Mono8"]), False),
        (Camera(["PolarizedMono8"], readable=False), False),
    ],
)
def test_only_the_camera_s_names_count(camera, polarised):
    assert is_polarised(camera) is polarised


@pytest.mark.parametrize(
    ("pixel_format", "mosaic"),
    [
        (by_name("Mono8"), True),
        (by_name("Mono12p"), True),
        (by_code(0x01080FFF), True),
        (by_code(0x81080001), False),
        (by_name("Confidence8"), False),
        (by_name("Data8"), False),
        (by_name("Mono8s"), False),
        (by_name("Coord3D_C16"), False),
        (by_name("R8"), False),
    ],
    ids=str,
)
def test_only_brightness_can_be_a_mosaic(pixel_format, mosaic):
    assert is_mosaic(Frame(np.zeros(64, np.uint8), 4, 4, pixel_format)) is mosaic


class FakeSources:
    opened, closing = Signal(object), Signal(object)


class SlowSource:
    """A source whose worker answers when the test says so."""

    def __init__(self):
        unit = Feature(name="Scan3dUnit", kind=FeatureKind.STRING, access=AccessMode.READ_ONLY, value="mm")
        self.grabber = ScriptedGrabber([unit])
        self.worker = SimpleNamespace(submit=lambda job, *, key, done: self.waiting.append((job, done)))
        self.waiting = []

    def answer(self):
        job, done = self.waiting.pop(0)
        done(job())


def test_a_fact_is_read_again_where_it_may_have_changed_and_never_reported_of_another_camera():
    sources, first, second = FakeSources(), SlowSource(), SlowSource()
    facts = []
    watch = CameraWatch(sources, lambda grabber: grabber.feature("Scan3dUnit").value, may_change)
    watch.changed.connect(facts.append)
    sources.opened.emit(first)
    first.answer()
    first.grabber.features_changed.emit(frozenset({"Gain"}))
    assert facts == ["mm"] and not first.waiting
    first.grabber.features_changed.emit(frozenset({"Scan3dUnit"}))
    sources.closing.emit(first)
    sources.opened.emit(second)
    first.answer()
    assert facts == ["mm"]
    second.answer()
    assert facts == ["mm", "mm"]
    first.grabber.features_changed.emit(frozenset({"Scan3dUnit"}))
    assert not first.waiting
