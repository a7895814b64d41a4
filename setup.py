"""What pyproject.toml cannot say: resources/ stands beside the package and is installed inside it."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["grabbergui*"]), "grabbergui.resources"],
    package_dir={"grabbergui.resources": "resources"},
)
