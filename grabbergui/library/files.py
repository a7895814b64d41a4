"""Files in a camera, as `camera.files`."""

from __future__ import annotations

from pathlib import Path

from grabbergui.core import file_access
from grabbergui.core.file_access import CameraFile, Written
from grabbergui.core.grabber import FrameGrabber


class CameraFiles:
    """The files in a camera (SFNC FileAccessControl): look-up tables, shading data, user sets, firmware.

    Names are those of FileSelector. Any thread may call; others use the camera meanwhile. Raises UsageError
    for a name that the camera does not list and for a camera without files, `CameraFileError` for what the
    camera refuses, and TransportError. Remote sources list files, and raise FeatureAccessError for all else.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber

    def list(self) -> tuple[CameraFile, ...]:
        """Return the files with `name`, `size` in bytes, `modes`, and the maker's `details`."""
        return tuple(file_access.list_files(self._grabber))

    def read(self, name: str) -> bytes:
        """Return a file's bytes."""
        return file_access.read_file(self._grabber, name)

    def write(self, name: str, content: bytes | Path, *, replace_firmware: bool = False) -> Written:
        """Replace a file by bytes, or by a file on this computer, and read it back.

        An upload that ends early cannot be resumed: write the whole file again. Firmware is refused without
        `replace_firmware`: a wrong file, or a power cut meanwhile, may leave the camera useless.
        """
        data = content.read_bytes() if isinstance(content, Path) else content
        return file_access.write_file(self._grabber, name, data, replace_firmware=replace_firmware)

    def delete(self, name: str) -> None:
        """Delete a file; firmware is refused."""
        file_access.delete_file(self._grabber, name)
