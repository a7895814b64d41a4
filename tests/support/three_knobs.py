"""A grabber of three features that are there and can be read, for what every grabber inherits."""

from grabbergui.core.features import AccessMode, Category, Feature, FeatureDescription, FeatureKind
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, FrameGrabber

NAMES = ("ExposureTime", "ExposureAuto", "Gain")


class ThreeKnobs(FrameGrabber):
    """Just enough of a grabber to ask for features."""

    access = Access.CONTROL
    streaming = False

    def open(self, access=Access.CONTROL):
        raise NotImplementedError

    def close(self):
        self._fanout.close()

    def feature_tree(self):
        members = tuple(FeatureDescription(name=name, kind=FeatureKind.FLOAT) for name in NAMES)
        return Category("Root", members=members)

    def has_feature(self, name):
        return name in NAMES

    def feature(self, name):
        self._require(name)
        return Feature(name=name, kind=FeatureKind.FLOAT, access=AccessMode.READ_WRITE, value=1.0)

    def write_feature(self, name, value):
        raise NotImplementedError

    def execute(self, name):
        raise NotImplementedError

    def start(self, *, keep_trigger=False):
        raise NotImplementedError

    def stop(self):
        raise NotImplementedError

    def statistics(self):
        return StreamStatistics()
