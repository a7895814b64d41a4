"""One-push by the camera itself: its automatic mode, once."""

from __future__ import annotations

import time

from grabbergui.core.companions import regulating
from grabbergui.core.errors import FeatureNotFoundError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import AUTO_ONCE, Role
from grabbergui.models.features.wording import value_text
from grabbergui.models.language import translate
from grabbergui.models.tuning.bench import TuningBench, TuningError
from grabbergui.models.tuning.knobs import automatic_once

PATIENCE = 10.0
"Seconds a camera may take; it needs a few frames."
LOOK = 0.1
"Seconds between two looks at whether it is done."


def has_once(grabber: FrameGrabber, role: Role) -> bool:
    """Whether the camera can do it by itself."""
    return automatic_once(grabber, role) is not None


def let_camera(bench: TuningBench, role: Role) -> str:
    """Let the camera regulate once, and wait until it is done. What came of it.

    Raises TuningError where it does not end, FeatureError, TransportError.
    """
    auto = bench.call(lambda grabber: automatic_once(grabber, role))
    if auto is None:
        raise FeatureNotFoundError(f"{bench.title} does not regulate this once by itself", role.names[0])
    bench.call(lambda grabber: grabber.write_feature(auto, AUTO_ONCE))
    begun = time.monotonic()
    while regulating(bench.call(lambda grabber: grabber.feature(auto))):
        seconds = time.monotonic() - begun
        if seconds > PATIENCE:
            text = translate("Tuning", "{0} was not done within {1:g} s; does the camera send frames?")
            raise TuningError(text.format(auto, PATIENCE))
        bench.say(seconds / PATIENCE, translate("Tuning", "{0} at work").format(auto))
        bench.wait(LOOK)
    if role is not Role.EXPOSURE:
        return translate("Tuning", "White balance set by the camera")
    name = bench.call(lambda grabber: role.find(grabber.has_feature)) or role.names[0]
    exposure = bench.call(lambda grabber: grabber.feature(name))
    return translate("Tuning", "Exposure set by the camera: {0}").format(value_text(exposure))
