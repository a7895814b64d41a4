"""The features of an open source: values, texts, scales, and the worker that reads and writes them."""
