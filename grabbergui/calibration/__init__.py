"""Camera calibration: boards and markers, the fit and its file, and hand–eye calibration."""
