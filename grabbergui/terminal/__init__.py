"""A camera by typed commands: the interpreter, and the console that runs it."""
