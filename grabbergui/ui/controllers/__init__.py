"""Controllers: each joins a few models to a few views."""
