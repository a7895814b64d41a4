"""Programs as a type checker sees them: `make lint` checks them with mypy, `make pyright` with pyright.

Both are strict. The programs are never run. `assert_type` fails where a type is wider or narrower than it
should be.
"""
