"""The Python library behind `import grabbergui`: cameras as context managers, frames as iterators.

Only what `grabbergui.__all__` lists is public. This package uses `models` for settings files and `recording`
for recordings; it imports no Qt.
"""
