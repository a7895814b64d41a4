"""Why a package cannot be imported, and the one command that helps.

Compiled packages fail in three ways: they are not installed, a library of the system is missing, or they were
built for another Python or processor. Every place that imports on demand uses this module for its message.
"""

from __future__ import annotations

import platform
import re
import sys
from pathlib import Path

from grabbergui.core.shell_words import shell_line

_LIBRARY = re.compile(r"(lib[\w.+-]+?\.so(?:\.[\d.]+)?|[\w.+-]+\.(?:dll|dylib))\b")
_DEBIAN = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libstdc++.so.6": "libstdc++6",
    "libgomp.so.1": "libgomp1",
    "libatomic.so.1": "libatomic1",
    "libfontconfig.so.1": "libfontconfig1",
    "libdbus-1.so.3": "libdbus-1-3",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
}
"Debian's packages by the libraries in them."
_PYTHON_LIBRARY = re.compile(r"libpython(\d+\.\d+)")
_DISTRIBUTIONS = {
    "cv2": "opencv-python-headless",
    "yaml": "PyYAML",
    "usb": "pyusb",
    "usb1": "libusb1",
    "libusb_package": "libusb-package",
    "gi": "PyGObject",
}
"Names on the package index, where they differ from the module's."
_OWNERS = {"_genapi": "genicam", "_gentl": "genicam"}
"Packages by those of their modules that report no more than their own name."
WINDOW = "PyQt5"


def explained(error: ImportError) -> str:
    """Return what is missing and the command that installs it, as one line of display text."""
    module = (error.name or "").partition(".")[0]
    library = _LIBRARY.search(str(error))
    if library is not None and "undefined symbol" not in str(error):
        who = f", which {_OWNERS.get(module, module)} needs," if module else ""
        return f"the system's library {library[1]}{who} is missing: {_library_remedy(library[1])}"
    if isinstance(error, ModuleNotFoundError) and module:
        return f"the package {module} is not installed: {install_command(module)}"
    why = " ".join(str(error).split())
    return (
        f"the package {module or 'in question'} is installed, but cannot be loaded ({why}):"
        " install grabbergui again in a new environment"
    )


def install_command(module: str) -> str:
    """Return the command that installs the package of a module."""
    if module == WINDOW and not window_has_wheels():
        return _system_window()
    name = _DISTRIBUTIONS.get(module, module)
    return shell_line([sys.executable, "-m", "pip", "install", name])


def window_has_wheels() -> bool:
    """Return whether PyQt5 has wheels for this computer; the marker in `pyproject.toml` says the same."""
    return sys.platform == "darwin" or platform.machine() in ("x86_64", "AMD64")


def _system_window() -> str:
    """Return the command for Debian's PyQt5, which an environment of its own does not see by itself."""
    install = "sudo apt-get install python3-pyqt5"
    if sys.prefix == sys.base_prefix:
        return install
    python = Path(sys.base_exec_prefix, "bin", f"python3.{sys.version_info[1]}")
    make = shell_line([str(python), "-m", "venv", "--system-site-packages", "--upgrade", sys.prefix])
    return f"{install} && {make}"


def _library_remedy(library: str) -> str:
    python = _PYTHON_LIBRARY.search(library)
    package = f"libpython{python[1]}" if python else _DEBIAN.get(library)
    if package is not None:
        return f"sudo apt-get install {package} (or your system's package with it)"
    return "install the package of your system that contains it"
