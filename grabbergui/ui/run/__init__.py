"""Composition roots: the program, one window, scripts."""
