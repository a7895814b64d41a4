"""The simulated camera: registers with their description, sensor and scene."""
