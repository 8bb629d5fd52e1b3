"""The grid of modes: leakage over EBM, in every scenario."""
