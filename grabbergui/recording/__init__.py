"""Recordings: writing frames to files, and playing files back as a source (`file:`)."""
