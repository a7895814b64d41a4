"""Recordings: writing frames to files, and playing files back as a source (`file:`).

A recording has frames with times, and a note with the metadata of each. Pixels are stored as in `Frame.raw`:
packed formats in 16-bit words, a Bayer pattern unconverted, so that playback delivers the sensor's values. A
note is a line of JSON.
"""
