"""Equations of motion as machine code, batched over lanes."""
