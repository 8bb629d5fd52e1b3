"""Wavelet features of the paper, arranged by level: views of the outputs of the indicator ``dwt``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import DWT
from hydrofdi.store.layout.names import APPROXIMATION_RMS, DETAIL_RMS, PHASE_DETAIL_RMS, SETTLED_DETAIL_RMS

_OUTPUT = {DETAIL_RMS: "d{}", APPROXIMATION_RMS: "a{}", PHASE_DETAIL_RMS: "d{}_phases"}
"""Variable → name pattern of the indicator outputs that it contains, by level."""


def wavelet_numbers(columns: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """``detail_rms``, ``approximation_rms`` and, if measured, ``phase_detail_rms`` of runs.

    Parameters
    ----------
    columns : mapping
        Variable name → array with one row per run.

    Returns
    -------
    dict of str to ndarray, shape (n_run, n_level) or (n_run, n_phase, n_level)
        NaN if ``dwt`` was not among the indicators.
    """
    numbers = {}
    for name, output in _OUTPUT.items():
        levels = range(1, 1 + sum(f"{DWT}.{output.format(level)}" in columns for level in range(1, 21)))
        if levels:
            arrays = [columns[f"{DWT}.{output.format(level)}"] for level in levels]
            numbers[name] = np.stack(arrays, axis=-1)
        elif name != PHASE_DETAIL_RMS:
            numbers[name] = np.full(columns[SETTLED_DETAIL_RMS].shape, np.nan)
    return numbers
