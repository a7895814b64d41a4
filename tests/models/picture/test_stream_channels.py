"""The stream channels of a camera are shown as components, each as it was last."""

import numpy as np

from grabbergui.core.component import ComponentKind
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name
from grabbergui.models.picture.components import labels
from grabbergui.models.picture.stream_channels import SILENCE, StreamChannels


def frame(channel, number):
    pixels = np.full(16, 10 * channel + number, np.uint8)
    return Frame(pixels, 4, 4, by_name("Mono8"), number, stream_channel=channel)


def test_one_channel_passes_as_it_is():
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
    assert channels.merged(alone, SILENCE + 0.05) is alone
    channels.merged(frame(1, 2), SILENCE + 0.1)
    channels.clear()
    alone = frame(0, 3)
    assert channels.merged(alone, SILENCE + 0.2) is alone
