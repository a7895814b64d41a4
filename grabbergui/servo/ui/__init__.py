"""The windows of the robot, in Qt: servoing, and hand–eye calibration."""
