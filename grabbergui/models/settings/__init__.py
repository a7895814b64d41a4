"""All settings of a camera: collecting, settings files, user sets, loading."""
