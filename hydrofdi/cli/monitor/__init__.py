"""Commands for a machine: train, detect, monitor, replay."""
