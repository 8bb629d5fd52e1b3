"""The constants of a data sheet whose change would explain most of the misfit of a balance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydrofdi.indicators.balancing import VolumeBalance, WindowOptions, counting_windows
from hydrofdi.indicators.estimation.chamber_balance import N_UNKNOWN, UNKNOWNS
from hydrofdi.indicators.estimation.flow_by_place import map_estimate
from hydrofdi.indicators.estimation.weak_rls import CORRELATED
from hydrofdi.indicators.nominal_actuator import plant_constants
from hydrofdi.records import RecordBatch
from hydrofdi.settings.messages import shown_quantity

_MOST_RECORDS, _LONGEST = 2, 20.0
"""Records of a batch, and their first part [s], that are looked at."""

_OCTAVES = np.linspace(-2.5, 2.5, 11)
"""Changes that are tried first, as powers of two."""

_MOST, _LIKE, _LEAST, _SURE = 0.75, 0.1, 0.05, 30.0
"""Share of the misfit that a constant must explain; how much less a second one may; least change; least
decrease of twice the negative logarithm of the likelihood."""

_IMPOSSIBLE = 1e9
"""Of a data sheet with which a chamber has no volume."""

_SAME_AS = {"flow_gain": ("area_gradient", "spool_gain")}
"""Constant → others that the balance sees only in their product."""


class Wrong(NamedTuple):
    """A constant that may be wrong, the value that would fit, and its share of the misfit."""

    name: str
    value: float
    share: float


def likeliest_wrong(options: WindowOptions, records: RecordBatch) -> list[Wrong]:
    """At most two constants, each of which alone would explain most of the misfit of healthy records."""
    from scipy.optimize import minimize_scalar

    records = records.rows(range(min(_MOST_RECORDS, records.n_record)))
    records = records.window(0, min(records.n_time, round(_LONGEST * records.sampling_frequency)))
    skipped = {name for others in _SAME_AS.values() for name in others} | {"damping_ratio", "position_zero"}
    known = [name for name in plant_constants(options) if name not in skipped]
    now = {name: value for name in known if (value := getattr(options, name))}

    def doubt(name: str, octaves: float) -> float:
        changed = options.model_copy(update={name: now[name] * 2.0**octaves})
        return _doubt(changed, records)

    whole, found = _doubt(options, records), list[Wrong]()
    for name in now if whole > _SURE else ():
        tried = [doubt(name, octaves) for octaves in _OCTAVES]
        best = float(_OCTAVES[int(np.argmin(tried))])
        step = float(_OCTAVES[1] - _OCTAVES[0])
        bounds = best - step, best + step
        fitted = minimize_scalar(lambda x, name=name: doubt(name, x), bounds=bounds, method="bounded",
                                 options={"xatol": 0.01, "maxiter": 10})  # fmt: skip
        if abs(fitted.x) > np.log2(1.0 + _LEAST):
            found.append(Wrong(name, now[name] * 2.0 ** float(fitted.x), float(1.0 - fitted.fun / whole)))
    found = [each for each in found if each.share > max(_MOST, _SURE / whole)]
    found.sort(key=lambda each: -each.share)
    return [each for each in found[:2] if each.share > found[0].share - _LIKE]


def sentence(options: WindowOptions, wrong: Sequence[Wrong]) -> str:
    """What is likeliest wrong, or that no single constant is."""
    units, said = plant_constants(options), list[str]()
    for name, value, share in wrong:
        now, fits = (shown_quantity(each, units[name]) for each in (getattr(options, name), value))
        whole = " · ".join((name, *_SAME_AS.get(name, ())))
        said.append(f"{whole} ({name} = {fits} instead of {now} would explain {share:.0%})")
    return f"likeliest wrong: {' or '.join(said)}" if said else "no single constant explains most of it"


def _doubt(options: WindowOptions, records: RecordBatch) -> float:
    """Twice the negative logarithm of the likelihood: of the residuals beyond the stated error, and of the
    unknowns beside their priors; zero if the data sheet is right.
    """
    balance = VolumeBalance(records, options)
    columns, targets = balance.equations(balance.spool)
    counts = counting_windows(balance.spool, records.sampling_frequency, options)
    known, total = options.assumptions(records), 0.0
    free = [UNKNOWNS.index(name) for name in ("internal_coefficient", "clearance")]
    for r in range(records.n_record):
        used = counts[r] > 0.0
        rows = (columns[r][used] * known.deviations / known.error).reshape(-1, N_UNKNOWN)
        if not (len(rows) and np.isfinite(rows).all()):
            return _IMPOSSIBLE
        found, residuals, *_ = map_estimate(
            rows, targets[r][used].ravel() / known.error, np.zeros(N_UNKNOWN), known
        )
        found[free] = 0.0
        square = max(1.0, float(np.mean(residuals**2)))
        total += len(rows) / CORRELATED * np.log(square) + float(np.sum(found**2))
    return total
