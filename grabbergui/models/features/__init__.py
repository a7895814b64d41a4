"""The features of an open source: which are shown, numbers and texts, and the worker for reads and writes."""
