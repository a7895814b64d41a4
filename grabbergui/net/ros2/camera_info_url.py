"""Where a served camera's calibration is kept: the parameter `camera_info_url`.

The URLs and the default place are those of ROS's `camera_info_manager`: `file:///folder/front.yaml`,
`package://my_robot/config/front.yaml`; `${NAME}` and `${ROS_HOME}` are filled in.
"""

from __future__ import annotations

import os
from pathlib import Path
from urllib.parse import unquote

from grabbergui.core.errors import UsageError

DEFAULT_URL = "file://${ROS_HOME}/camera_info/${NAME}.yaml"
"""The place of a camera for which no other is given."""


def path_of(url: str, camera: str) -> Path:
    """The file that a URL means for the camera of that full name. Raises UsageError.

    The name stands in the file's with `_` for `/`, so that cameras of two namespaces have two files.
    """
    filled = (url or DEFAULT_URL).replace("${NAME}", camera.strip("/").replace("/", "_"))
    filled = filled.replace("${ROS_HOME}", os.environ.get("ROS_HOME") or str(Path.home() / ".ros"))
    scheme, _, rest = filled.partition("://")
    if scheme == "file" and rest.startswith("/"):
        return Path(unquote(rest))
    package, _, inside = rest.partition("/")
    if scheme == "package" and package and inside:
        return _share_of(package, url) / unquote(inside)
    raise UsageError(
        f"camera_info_url {url}: write file:///folder/camera.yaml or package://PACKAGE/camera.yaml"
    )


def _share_of(package: str, url: str) -> Path:
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    try:
        return Path(get_package_share_directory(package))
    except (PackageNotFoundError, ValueError, OSError) as error:  # no name of a package; no index to look in
        raise UsageError(f"camera_info_url {url}: package {package} is not found: {error}") from error
