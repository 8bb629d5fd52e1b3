"""The leaky modes of an experiment as arrays over readings, leakages, EBM and levels.

A *reading* is one set of values of everything that varies besides leakage and EBM: an experiment without such
parameters has a single reading, an ensemble has thousands. Claims and controls are evaluated on all of them
at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.report.table import baseline_changes, label_names, leakage_request, normal_bulk_modulus
from hydrofdi.store import ExperimentData, names

ABSENT = -1
"""Position of a run that the experiment does not ask for."""

Mode = tuple[int, int]
"""Positions of a leakage and of an EBM in a grid."""


@dataclass(frozen=True)
class ModeGrid:
    """δ of all modes.

    Attributes
    ----------
    readings : tuple of dict
        Varied parameter → value in SI, for each reading.
    leakage_flows : tuple of float
        Leakage levels [m³/s], ascending, without the sealed one; at the normal EBM where K_i itself is given.
    bulk_moduli : tuple of float
        β [Pa], ascending.
    normal : int
        Position of the normal β.
    positions : ndarray of int, shape (n_reading, 1 + n_leakage, n_bulk_modulus)
        Rows of the runs in the experiment, the sealed ones first; ``ABSENT`` where there is none.
    fixed, matched : ndarray, shape (n_reading, 1 + n_leakage, n_bulk_modulus, n_level)
        δ [%] against the fixed and the matched baseline; NaN where a run is absent, failed or missing.
    """

    readings: tuple[dict[str, Any], ...]
    leakage_flows: tuple[float, ...]
    bulk_moduli: tuple[float, ...]
    normal: int
    positions: NDArray[np.int64]
    fixed: NDArray[np.float64]
    matched: NDArray[np.float64]

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return int(self.fixed.shape[-1])

    @property
    def leaky(self) -> NDArray[np.float64]:
        """δ against the fixed baseline of the leaky modes."""
        return self.fixed[:, 1:]

    def planned(self, leakage: int, bulk_modulus: int) -> bool:
        """Whether the experiment asks for a leaky mode."""
        return bool(self.positions[:, 1 + leakage, bulk_modulus].min() > ABSENT)

    def modes(self, leakage: int | None = None, bulk_modulus: int | None = None) -> list[Mode]:
        """The leaky modes that the experiment asks for; all, or those of one leakage or EBM."""
        leakages = range(len(self.leakage_flows)) if leakage is None else (leakage,)
        moduli = range(len(self.bulk_moduli)) if bulk_modulus is None else (bulk_modulus,)
        return [(q, b) for q in leakages for b in moduli if self.planned(q, b)]

    @property
    def raised(self) -> list[int]:
        """Positions of the β above the normal one."""
        return list(range(self.normal + 1, len(self.bulk_moduli)))


def arrange_modes(data: ExperimentData) -> ModeGrid:
    """The grid of an experiment.

    Parameters
    ----------
    data : ExperimentData
        An experiment as it was read.
    """
    kept = _without_more_external_leakage(data)
    runs = [data.table.runs[position].parameters for position in kept]
    labels = [name for name in label_names(data) if len(kept) == data.n_run or _varies(name, runs)]
    keys = [tuple(run.told(name) for name in labels) for run in runs]
    reading_keys = list(dict.fromkeys(keys))
    requests = [leakage_request(data, position) for position in kept]
    leakages = sorted({0.0, *requests})
    bulk_moduli = sorted({run.fluid.bulk_modulus for run in runs})
    normal = bulk_moduli.index(normal_bulk_modulus(data))
    positions = np.full((len(reading_keys), len(leakages), len(bulk_moduli)), ABSENT)
    places = (
        _ranks(keys, reading_keys),
        _ranks(requests, leakages),
        _ranks([run.fluid.bulk_modulus for run in runs], bulk_moduli),
    )
    positions[places] = kept
    _share_sealed_runs(positions, data.columns[names.MATCHED_BASELINE])
    fixed, matched = baseline_changes(data)
    return ModeGrid(
        readings=tuple(dict(zip(labels, key, strict=True)) for key in reading_keys),
        leakage_flows=tuple(_flow(data, positions[0, 1 + q], normal) for q in range(len(leakages) - 1)),
        bulk_moduli=tuple(bulk_moduli),
        normal=normal,
        positions=positions,
        fixed=_gathered(fixed, positions),
        matched=_gathered(matched, positions),
    )


def _share_sealed_runs(positions: NDArray[np.int64], matched: NDArray[Any]) -> None:
    """Give readings without sealed runs of their own those that their leaky runs are compared with.

    What differs in the leakage alone, such as its law, is the same once the actuator is sealed.
    """
    for reading, _, beta in np.argwhere(positions[:, :1] == ABSENT):
        leaky = positions[reading, 1:, beta]
        if (leaky != ABSENT).any():
            positions[reading, 0, beta] = matched[leaky[leaky != ABSENT][0]]


def _without_more_external_leakage(data: ExperimentData) -> list[int]:
    """Positions of the runs whose chambers leak no more than those of their healthy run.

    Modes are of internal leakage and EBM; what leaks out besides is another fault.
    """
    runs = [run.parameters.leakage for run in data.table.runs]
    flows = [(leakage.chamber_1_coefficient, leakage.chamber_2_coefficient) for leakage in runs]
    matched = data.columns[names.MATCHED_BASELINE]
    return [k for k in range(data.n_run) if data.experiment.has_readings or flows[k] == flows[matched[k]]]


def _varies(name: str, runs: list[RunParameters]) -> bool:
    return len({run.told(name) for run in runs}) > 1


def _ranks(values: list[Any], order: list[Any]) -> NDArray[np.int64]:
    rank = {value: position for position, value in enumerate(order)}
    return np.array([rank[value] for value in values])


def _gathered(changes: NDArray[np.float64], positions: NDArray[np.int64]) -> NDArray[np.float64]:
    return np.where((positions == ABSENT)[..., None], np.nan, changes[positions])


def _flow(data: ExperimentData, positions: NDArray[np.int64], normal: int) -> float:
    """Leakage level of the runs of one leakage: as it was asked for, or as it is at the normal EBM."""
    position = positions[normal] if positions[normal] != ABSENT else positions[positions != ABSENT][0]
    asked = float(data.columns[names.LEAKAGE_LEVEL][position])
    return asked if asked == asked else float(data.columns[names.MEAN_LEAKAGE_FLOW][position])
