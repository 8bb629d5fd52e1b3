"""Outputs of indicators as variables of a file: ``label.output``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import DWT, Indicators
from hydrofdi.config.run_table.runs import Runs
from hydrofdi.store.layout import names
from hydrofdi.store.layout.names import Variable
from hydrofdi.transforms.wavelet import n_phase


def is_output(name: str) -> bool:
    """Whether a variable belongs to an indicator; only such names contain a dot."""
    return "." in name


def indicators_of(runs: Runs) -> list[Indicators]:
    """Distinct indicator sets of the runs."""
    return [runs.choice.made(request.wavelet) for request in runs.distinct("wavelet")]


def is_needless(name: str, values: NDArray[Any]) -> bool:
    """Whether a variable can be omitted: obstacles, if no record has one."""
    return name.endswith(names.OBSTACLE) and not any(values)


def cf_unit(unit: str) -> str:
    """A unit in the style of the CF conventions: ``m3 s-1`` for ``m^3/s``."""
    first, *divisors = unit.replace("·", " ").replace("^", "").split("/")
    factors = [*first.split(), *map(_inverse, divisors)]
    return " ".join(factors[1:] if divisors and factors[0] == "1" else factors)


def _inverse(unit: str) -> str:
    """A unit with a negative exponent: ``kg-0.5`` for ``kg0.5``."""
    name = unit.rstrip("0123456789.")
    return f"{name}-{unit[len(name) :] or 1}"


def output_variables(measured: Iterable[Indicators]) -> tuple[Variable, ...]:
    """Variables for the outputs of indicators, each once."""
    variables: dict[str, Variable] = {}
    for indicators in measured:
        for label, indicator in indicators.items():
            name = f"{label}{names.ANALYSIS_ID}"
            text = f"identity of the analysis {label}: hash of the record, the indicator and its options"
            variables[name] = Variable(name, (names.RUN,), "", text)
            name = f"{label}{names.OBSTACLE}"
            variables[name] = Variable(
                name, (names.RUN,), "", f"why {label} could not be measured; empty if it was"
            )
            for output in indicator.outputs:
                dimensions = (names.RUN, *(f"{label}.{dimension}" for dimension in output.dims))
                name = f"{label}.{output.name}"
                variables[name] = Variable(name, dimensions, cf_unit(output.unit), output.long_name)
    return tuple(variables.values())


def dimensions(runs: Runs) -> dict[str, int]:
    """All dimensions of the variables of runs, and their lengths."""
    wavelets = [request.wavelet for request in runs.distinct("wavelet")]
    levels = max((wavelet.levels for wavelet in wavelets), default=0)
    phases = max((n_phase(wavelet.levels) for wavelet in wavelets if wavelet.phase == "all"), default=0)
    return {names.RUN: len(runs), names.LEVEL: levels, names.PHASE: phases} | output_dimensions(
        indicators_of(runs)
    )


def output_dimensions(measured: Iterable[Indicators]) -> dict[str, int]:
    """Dimensions of these variables other than the run, and their largest lengths."""
    lengths: dict[str, int] = {}
    for indicators in measured:
        for label, indicator in indicators.items():
            for output in indicator.outputs:
                for dimension, length in output.dims.items():
                    name = f"{label}.{dimension}"
                    lengths[name] = max(length, lengths.get(name, 0))
    return lengths


_OUTPUT = {names.DETAIL_RMS: "d{}", names.APPROXIMATION_RMS: "a{}", names.PHASE_DETAIL_RMS: "d{}_phases"}
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
        elif name != names.PHASE_DETAIL_RMS:
            numbers[name] = np.full(columns[names.SETTLED_DETAIL_RMS].shape, np.nan)
    return numbers
