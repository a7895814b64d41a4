"""A disk that is full."""

import errno


class FullDisk:
    """A file that takes so many bytes and no more, as a disk does."""

    def __init__(self, raw, room):
        self.raw, self.room = raw, room

    def __getattr__(self, name):
        return getattr(self.raw, name)

    def write(self, data):
        fits = min(len(data), self.room)
        self.raw.write(data[:fits])
        self.room -= fits
        if fits < len(data):
            raise OSError(errno.ENOSPC, "No space left on device")
        return fits
