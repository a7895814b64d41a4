"""What pyproject.toml cannot say: resources/ stands beside the package and is installed inside it."""

from setuptools import find_namespace_packages, setup

# Folders of data are named too: setuptools warns at length of each that it finds by itself.
ours = find_namespace_packages(include=["grabbergui*"], exclude=["*__pycache__*"])
resources = [f"grabbergui.resources.{name}" for name in find_namespace_packages("resources")]

setup(
    packages=[*ours, "grabbergui.resources", *resources],
    package_dir={"grabbergui.resources": "resources"},
)
