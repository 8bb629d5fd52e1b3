"""The table of an experiment, made from its arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from hydrofdi.quality.doubts import DOUBTS
from hydrofdi.report.runs.changes import (
    baseline_changes,
    external_coefficients,
    label_names,
    leaks_out_more,
    normal_bulk_modulus,
)
from hydrofdi.report.runs.rows import ExternalLeakage, LevelChanges, TableRow
from hydrofdi.report.runs.table import SensitivityTable
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.transforms.wavelet import level_bands

_NUMBERS = (
    names.LEAKAGE_LEVEL, names.MEAN_LEAKAGE_FLOW, names.LEAKAGE_COEFFICIENT, names.BULK_MODULUS,
    names.MODE_FREQUENCY, names.MODE_DAMPING_RATIO, names.MEAN_CHAMBER_1_PRESSURE,
    *names.EXTERNAL_LEAKAGE_FLOWS,
)  # fmt: skip
_TEXTS = (names.RUN_ID, names.STATUS, names.MESSAGE, names.VERDICT)

_FEATURES = (
    names.DETAIL_RMS,
    names.APPROXIMATION_RMS,
    names.SETTLED_DETAIL_RMS,
    names.SETTLED_APPROXIMATION_RMS,
)


def summarize_table(data: ExperimentData) -> SensitivityTable:
    """The table of an experiment.

    Parameters
    ----------
    data : ExperimentData
        An experiment as it was read.
    """
    rows = _in_order(list(_rows(data)))
    n_level = data.columns[names.DETAIL_RMS].shape[1]
    return SensitivityTable(
        name=data.experiment.name,
        rows=tuple(rows),
        bands=tuple(level_bands(data.experiment.record.sampling_frequency, n_level)),
        normal_bulk_modulus=normal_bulk_modulus(data),
        baseline=data.experiment.baseline,
    )


def _in_order(rows: list[TableRow]) -> list[TableRow]:
    """Sealed rows first, then by leakage, EBM and further parameters; words in the order of the file."""
    labels = {name: [row.labels[name] for row in rows] for name in rows[0].labels}
    places = {
        name: {value: place for place, value in enumerate(dict.fromkeys(values))}
        for name, values in labels.items()
        if not all(isinstance(value, int | float) for value in values)
    }

    def key(row: TableRow) -> tuple[Any, ...]:
        others = (places[name][value] if name in places else value for name, value in row.labels.items())
        return (not row.is_sealed, row.leakage_request, row.bulk_modulus, *others)

    return sorted(rows, key=key)


def _changes(data: ExperimentData, name: str) -> list[LevelChanges]:
    """RMS and δ of one kind of coefficient, run by run."""
    arrays = (data.columns[name], *baseline_changes(data, name))
    return [
        LevelChanges(*map(tuple, levels))
        for levels in zip(*(array.tolist() for array in arrays), strict=True)
    ]


def _rows(data: ExperimentData) -> Iterator[TableRow]:
    """The rows in the order of the runs, replicates left out."""
    numbers = {
        name: data.columns[name].tolist()
        for name in (*_NUMBERS, *(doubt.number for doubt in DOUBTS.values()))
    }
    texts = {name: data.columns[name].astype(str).tolist() for name in _TEXTS}
    labels = {name: data.values(name) for name in label_names(data)}
    features = [_changes(data, name) for name in _FEATURES]
    requests, coefficients = data.leakage_requests.tolist(), external_coefficients(data)
    flows = list(zip(*(numbers[name] for name in names.EXTERNAL_LEAKAGE_FLOWS), strict=True))
    of_replicate = data.replicate_of.tolist()
    for k, more in enumerate(leaks_out_more(data).tolist()):
        if of_replicate[k] != names.NO_BASELINE:
            continue
        status, level = texts[names.STATUS][k], numbers[names.LEAKAGE_LEVEL][k]
        yield TableRow(
            run_id=texts[names.RUN_ID][k],
            labels={name: values[k] for name, values in labels.items()},
            leakage_request=requests[k],
            leakage_flow=numbers[names.MEAN_LEAKAGE_FLOW][k] if math.isnan(level) else level,
            mean_leakage_flow=numbers[names.MEAN_LEAKAGE_FLOW][k],
            leakage_coefficient=numbers[names.LEAKAGE_COEFFICIENT][k],
            bulk_modulus=numbers[names.BULK_MODULUS][k],
            mode_frequency=numbers[names.MODE_FREQUENCY][k],
            mode_damping_ratio=numbers[names.MODE_DAMPING_RATIO][k],
            details=features[0][k],
            approximations=features[1][k],
            settled_details=features[2][k],
            settled_approximations=features[3][k],
            position=k,
            external=ExternalLeakage(coefficients[k], flows[k]),
            mean_pressure=numbers[names.MEAN_CHAMBER_1_PRESSURE][k],
            status=status,
            message=texts[names.MESSAGE][k],
            verdict=texts[names.VERDICT][k] if status == "ok" else status,
            doubt_numbers={word: numbers[doubt.number][k] for word, doubt in DOUBTS.items()},
            leaks_out_more=more,
        )
