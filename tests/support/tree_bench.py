"""A feature tree on a scripted grabber, and all that it reports."""

import threading

from fakes import ScriptedGrabber
from grabbergui.core.features import AccessMode, Feature, FeatureKind
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from patience import PATIENCE


def number(name, value=1.0, **more):
    """Return a writable number from 0 to 100."""
    fields = {"minimum": 0.0, "maximum": 100.0, "access": AccessMode.READ_WRITE, **more}
    return Feature(name=name, kind=FeatureKind.FLOAT, value=value, **fields)


class Stage:
    """A model on a scripted grabber, and all its signals."""

    def __init__(self, *features, kind=ScriptedGrabber):
        self.grabber = kind(features)
        self.worker = FeatureWorker("worker")
        self.model = FeatureTreeModel(self.grabber, self.worker)
        self.changed, self.errors = [], []
        self.model.feature_changed.connect(self.changed.append)
        self.model.failed.connect(self.errors.append)

    def settle(self):
        """Wait until the worker has nothing to do, delayed writes included."""
        for delay in (0.06, 0, 0):
            idle = threading.Event()
            self.worker.submit(lambda: None, done=lambda _, idle=idle: idle.set(), delay=delay)
            assert idle.wait(PATIENCE)

    def values(self, name):
        """Return the values of a feature that the model reported, in order."""
        return [feature.value for feature in self.changed if feature.name == name]

    def written(self, name):
        """Return the values that were written to a feature, in order."""
        return [value for written, value, _ in self.grabber.writes if written == name]


class RemoteScript(ScriptedGrabber):
    """Reads up to four features by one request."""

    reads_at_once = 4

    def __init__(self, features):
        super().__init__(features)
        self.requests = []

    def read_features(self, names):
        self.requests.append(len(names))
        return super().read_features(names)
