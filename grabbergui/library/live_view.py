"""A live view for scripts and notebooks, without the application's window.

The headless OpenCV that this package needs has no `imshow`; Matplotlib shows frames in a script, and in
Jupyter `ipywidgets` adds controls for exposure time and gain. Neither is a dependency.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import threading
from typing import Any

from grabbergui.core.encoded_image import jpeg_to_show
from grabbergui.core.errors import FrameTimeoutError, GrabberError, SourceUnavailableError
from grabbergui.core.features import Feature
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.sfnc import Role
from grabbergui.library.camera import Camera

RATE = 15.0
"Images shown per second, at most."
FIRST_FRAME = 5.0
"Seconds to wait for the first image."


def live_view(camera: Camera) -> object:
    """Show a camera's frames live: a panel in Jupyter if `ipywidgets` is installed, else a Matplotlib figure.

    In a script, the figure stays until it is closed. In Jupyter the panel (a `NotebookPanel`) is returned and
    shown; `close` ends it. Raises SourceUnavailableError if neither package is installed, and
    FrameTimeoutError if no frame comes.
    """
    if _in_notebook():
        with contextlib.suppress(ImportError):
            return NotebookPanel(camera, importlib.import_module("ipywidgets"))
    try:
        pyplot = importlib.import_module("matplotlib.pyplot")
    except ImportError as error:
        raise SourceUnavailableError(
            "a live view needs Matplotlib (pip install matplotlib), or ipywidgets in Jupyter"
        ) from error
    return _show_figure(camera, pyplot)


def _in_notebook() -> bool:
    try:
        shell = importlib.import_module("IPython").get_ipython()
    except ImportError:
        return False
    return shell is not None and "IPKernelApp" in shell.config


def _show_figure(camera: Camera, pyplot: Any) -> object:
    camera.start()
    queue = camera.grabber.open_queue(depth=1)
    try:
        first = queue.get(FIRST_FRAME).rgb()
    except BaseException:
        queue.close()
        raise
    figure, axes = pyplot.subplots(num=camera.info.title)
    axes.set_axis_off()
    shown = axes.imshow(first)

    def update(_: Camera = camera) -> None:  # open as long as it is shown
        with contextlib.suppress(FrameTimeoutError):
            shown.set_data(queue.get(0.0).rgb())
            figure.canvas.draw_idle()

    timer = figure.canvas.new_timer(interval=round(1000 / RATE))
    timer.add_callback(update)
    timer.start()
    figure.canvas.mpl_connect("close_event", lambda _: timer.stop())
    figure.canvas.mpl_connect("close_event", lambda _: queue.close())
    pyplot.show()
    return figure


class NotebookPanel:
    """The image of a camera with sliders for exposure time and gain, made of `ipywidgets`."""

    def __init__(self, camera: Camera, widgets: Any) -> None:
        self._camera = camera
        self._image = widgets.Image(format="jpeg")
        self._status = widgets.Label()
        sliders = [self._slider(widgets, role) for role in (Role.EXPOSURE, Role.GAIN)]
        self.widget = widgets.VBox([self._image, *filter(None, sliders), self._status])
        "The panel itself, for the caller's own layout."
        camera.start()
        self._closed = threading.Event()
        self._sink = FrameSink(
            camera.grabber, self._show, name="notebook panel", depth=1, failed=self._on_sink_failed
        )
        self._sink.start()

    def close(self) -> None:
        """Stop updating. The camera goes on streaming."""
        self._closed.set()
        self._sink.stop()

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)

    def _slider(self, widgets: Any, role: Role) -> Any:
        name = self._camera.grabber.role(role)
        feature = self._camera.feature(name) if name is not None else None
        if feature is None or not isinstance(feature.value, int | float) or feature.maximum is None:
            return None
        slider = _slider_of(widgets, feature)
        slider.observe(lambda change: self._write(feature.name, change["new"]), "value")
        return slider

    def _write(self, name: str, value: float) -> None:
        try:
            self._status.value = f"{name} = {self._camera.write(name, value)}"
        except GrabberError as error:
            self._status.value = str(error)

    def _show(self, frame: Frame) -> None:
        self._image.value = jpeg_to_show(frame.rgb())
        self._closed.wait(1 / RATE)

    def _on_sink_failed(self, error: Exception, frame: Frame) -> None:
        self._status.value = str(error)


def _slider_of(widgets: Any, feature: Feature) -> Any:
    low, high = float(feature.minimum or 0), float(feature.maximum or 1)
    text = f"{feature.title} [{feature.unit}]" if feature.unit else feature.title
    common = {"value": feature.value, "description": text, "continuous_update": True}
    if feature.logarithmic and low > 0:
        return widgets.FloatLogSlider(min=math.log10(low), max=math.log10(high), **common)
    return widgets.FloatSlider(min=low, max=high, step=(high - low) / 1000, **common)
