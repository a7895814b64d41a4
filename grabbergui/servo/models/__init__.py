"""What the windows of the robot know: servoing, and hand–eye calibration. No Qt."""

from grabbergui.servo.models import sentences  # noqa: F401  # errors are translated wherever models are used
