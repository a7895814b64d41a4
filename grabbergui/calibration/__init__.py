"""Camera calibration: boards and markers, poses, the fit and its file."""
