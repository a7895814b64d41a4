"""Where tunings are tried: a camera without any automatic, its tracked handle, and reports of progress."""

import threading
from dataclasses import replace

import numpy as np

from fakes import ScriptedGrabber
from frames import frame_of
from grabbergui.core.features import AccessMode, EnumEntry, Feature, FeatureKind
from grabbergui.core.pixels import Region
from grabbergui.models.change_journal import ChangeJournal
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker
from grabbergui.models.light import measure_light
from grabbergui.models.one_push import OnePush
from patience import PATIENCE

REGION = Region(100, 80, 120, 100)


class PlainCamera(ScriptedGrabber):
    """Makes frames by what its features say, some frames late; a grey scene under a coloured lamp."""

    LATE = 3

    def __init__(self, *, lamp=(0.5, 1.0, 0.7), light=1.0, pixel_format="RGB8", gain=True, rate=30.0):
        def number(name, value, low, high, **more):
            more = {"access": AccessMode.READ_WRITE, "minimum": low, "maximum": high, **more}
            return Feature(name=name, kind=more.pop("kind", FeatureKind.FLOAT), value=value, **more)

        features = [
            number("ExposureTimeRaw", 1000, 20, 1_000_000, kind=FeatureKind.INTEGER, unit="us", increment=20),
            number("AcquisitionFrameRate", rate, 1.0, 100.0, unit="Hz"),
            Feature(
                name="BalanceRatioSelector", kind=FeatureKind.ENUMERATION, value="Green",
                entries=tuple(EnumEntry(n) for n in ("Red", "Green", "Blue")), access=AccessMode.READ_WRITE,
            ),
            number("BalanceRatio", 1.0, 0.25, 4.0, selectors=("BalanceRatioSelector",)),
        ]  # fmt: skip
        if gain:
            features.append(number("GainRaw", 0, 0, 480, kind=FeatureKind.INTEGER))
        super().__init__(features)
        self.lamp, self.light, self.pixel_format = lamp, light, pixel_format
        self.ratios = {"Red": 1.0, "Green": 1.0, "Blue": 1.0}
        self.past = []
        self.sending = threading.Event()
        self.sending.set()
        self._ended = threading.Event()
        self._sender = threading.Thread(target=self._send)
        self._sender.start()

    def write_feature(self, name, value):
        feature = super().write_feature(name, value)
        if name == "BalanceRatioSelector":
            self.known["BalanceRatio"] = self._with_value("BalanceRatio", self.ratios[value])
        elif name == "BalanceRatio":
            self.ratios[self.known["BalanceRatioSelector"].value] = feature.value
        return feature

    def _with_value(self, name, value):
        known = self.known[name]
        return replace(known, value=value)

    def close(self):
        self._ended.set()
        self._sender.join()
        super().close()

    def _send(self):
        while not self._ended.wait(0.002):
            gain = 10 ** (self.known["GainRaw"].value / 10 / 20) if "GainRaw" in self.known else 1
            light = self.known["ExposureTimeRaw"].value / 10_000 * gain * self.light
            ratios = self.ratios.values()
            colour = [light * part * ratio for part, ratio in zip(self.lamp, ratios, strict=True)]
            self.past = [*self.past, colour][-self.LATE :]
            if self.sending.is_set():
                self._fanout.put(self._frame(self.past[0]))

    def _frame(self, colour):
        if self.pixel_format == "Mono8":
            pixels = np.full((200, 300), min(255, round(255 * 0.5 * colour[1])), np.uint8)
        else:
            values = [min(255, round(255 * 0.5 * part)) for part in colour]
            pixels = np.broadcast_to(np.array(values, np.uint8), (200, 300, 3))
        return frame_of(pixels, self.pixel_format)


class Stage:
    """A camera, its tracked handle, and a tuning."""

    def __init__(self, grabber):
        self.grabber = grabber
        self.worker = FeatureWorker()
        self.journal = ChangeJournal()
        self.tracked_grabber = ChangeTrackingGrabber(grabber, self.journal)
        self.tracked_grabber.open()
        self.features = FeatureTreeModel(self.tracked_grabber, self.worker)
        self.push = OnePush()
        self.progress, self.results, self.failures = [], [], []
        self.push.progressed.connect(lambda share, text: self.progress.append((share, text)))
        self.push.succeeded.connect(self.results.append)
        self.push.failed.connect(self.failures.append)

    def run(self, tuning, name="Exposure"):
        assert self.push.start(name, tuning, self.tracked_grabber, self.features)
        assert self.push.wait(PATIENCE)
        return self.results[-1] if self.results else ""

    def value(self, name):
        return self.grabber.feature(name).value

    def light(self, region=REGION):
        queue = self.grabber.open_queue()
        try:
            for _ in range(5):
                frame = queue.get(PATIENCE)
            return measure_light(frame, region)
        finally:
            queue.close()

    def close(self):
        self.push.cancel()
        assert self.push.wait(PATIENCE)
        self.features.close()
        self.tracked_grabber.close()
        assert self.worker.close()
        self.grabber.close()


def on(region, tuning):
    return lambda bench: tuning(bench, region)
