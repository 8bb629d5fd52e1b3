"""Kernels compiled to machine code, which is kept on disk."""
