"""Hand–eye calibration: the pose of a camera on a robot, which moves and looks at a target."""
