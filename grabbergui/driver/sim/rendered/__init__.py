"""A rendered room for the simulated camera, with a marker that moves."""
