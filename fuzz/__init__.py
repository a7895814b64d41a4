"""Coverage-guided fuzzing of everything that reads foreign data: `python -m fuzz [NAME …] --seconds 60`.

Each module here without an underscore is a target: `seeds()` returns the first inputs, and `one_input(data)`
feeds one to the parsers. It raises only if they misbehave: an exception that is not theirs, contradicting
results, unbounded time or memory.
"""
