"""hydrofdi from Python: what the commands do, for scripts and notebooks (docs/python.md).

What the user can fix raises the same sentence as on the command line, as a `HydrofdiError`.
"""
