"""The build steps that pyproject.toml cannot express: resources, docs and examples, and the README."""

import re
from pathlib import Path

from setuptools import find_namespace_packages, setup

# Folders of data are named too: setuptools warns at length of each that it finds by itself.
ours = find_namespace_packages(include=["grabbergui*"], exclude=["*__pycache__*"])
resources = [f"grabbergui.resources.{name}" for name in find_namespace_packages("resources")]
manual = [f"grabbergui.manual.{name}" for name in find_namespace_packages("docs")]


INSTALLING = """```sh
pip install grabbergui
grabbergui            # the window, on a simulated camera
grabbergui doctor     # what this computer lacks for real cameras
```

Python 3.10 to 3.14 on Linux, Windows or macOS. On Linux computers with other processors than x86-64
(Raspberry Pi, Jetson) everything but the window works; the window needs Debian's python3-pyqt5.
"""


def description() -> str:
    """Return the README for the package index.

    It begins with `pip install`. Images are left out, and relative links are plain text: both need the
    repository.
    """
    text = Path(__file__).with_name("README.md").read_text("utf-8")
    text = re.sub(r"```sh\nmake run.*?(?=\n## )", INSTALLING, text, count=1, flags=re.DOTALL)
    text = re.sub(r"<picture>.*?</picture>\n*", "", text, flags=re.DOTALL)
    return re.sub(r"\[([^]]+)\]\((?!https?:)[^)]+\)", r"\1", text)


setup(
    packages=[*ours, "grabbergui.resources", *resources, "grabbergui.manual", *manual, "grabbergui.examples"],
    package_dir={
        "grabbergui.resources": "resources",
        "grabbergui.manual": "docs",
        "grabbergui.examples": "examples",
    },
    long_description=description(),
    long_description_content_type="text/markdown",
)
