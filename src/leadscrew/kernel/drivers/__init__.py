"""The drivers: ordinary functions in the step subset that run a loop, specialised by linking their hooks.

A hook (``hooks.py``) is a name that the linker binds to the loop's own blocks and types. No driver is text: each is
read like a user's step, so that lint, type checks and the debugger see it.
"""
