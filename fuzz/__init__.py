"""Coverage-guided fuzzing of everything that reads foreign data: `python -m fuzz [NAME …] --seconds 60`.

Each module here without an underscore is a target: `seeds()` gives inputs to begin with, `one_input(data)`
feeds one to the parsers and raises only where they misbehave: an exception that is not their own, a result
that contradicts another, time or memory without bound.
"""
