"""As `each_window`, for the windows of a robot: the servoing window is a process of its own, this program."""

import os

from each_window import serve
from grabbergui.servo.ui import servo_process

if __name__ == "__main__":
    if "CLOSED" in os.environ:
        servo_process.main()
    else:
        import grabbergui.driver.device_grabber
        import grabbergui.driver.sim.device
        import grabbergui.servo.closed_loop  # noqa: F401

        servo_process.WINDOW_PROGRAM[:] = [__file__]
        serve()
