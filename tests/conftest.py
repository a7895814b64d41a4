"""Its presence makes the modules of this folder, such as `fakes`, importable from every test."""

pytest_plugins = ["peers"]
