"""Recordings: how frames lie in files, and recordings as sources (`file:`)."""
