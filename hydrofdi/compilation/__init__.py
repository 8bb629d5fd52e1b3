"""Compilation of kernels to machine code, cached on disk."""
