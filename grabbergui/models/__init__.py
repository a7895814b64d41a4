"""State and rules of the window, without Qt."""
