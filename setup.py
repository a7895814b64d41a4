"""The build steps that pyproject.toml cannot express: installs resources/ and docs/, adapts the README."""

import re
from pathlib import Path

from setuptools import find_namespace_packages, setup

# Folders of data are named too: setuptools warns at length of each that it finds by itself.
ours = find_namespace_packages(include=["grabbergui*"], exclude=["*__pycache__*"])
resources = [f"grabbergui.resources.{name}" for name in find_namespace_packages("resources")]
manual = [f"grabbergui.manual.{name}" for name in find_namespace_packages("docs")]


def description() -> str:
    """Return the README without images, and relative links as plain text: both need the repository."""
    text = Path(__file__).with_name("README.md").read_text("utf-8")
    text = re.sub(r"<picture>.*?</picture>\n*", "", text, flags=re.DOTALL)
    return re.sub(r"\[([^]]+)\]\((?!https?:)[^)]+\)", r"\1", text)


setup(
    packages=[*ours, "grabbergui.resources", *resources, "grabbergui.manual", *manual],
    package_dir={"grabbergui.resources": "resources", "grabbergui.manual": "docs"},
    long_description=description(),
    long_description_content_type="text/markdown",
)
