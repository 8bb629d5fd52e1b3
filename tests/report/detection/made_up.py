"""A study of detection with scores that are drawn from Gaussians."""

from dataclasses import replace

import numpy as np

from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.report.detection.report import DetectionReport
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored
from tests.studies.populations import FIT, TEST, study

LITRES_PER_MINUTE = 1e-3 / 60.0
SEVERITIES = tuple(np.geomspace(0.01, 1.0, 9))
P1, P2, X, U = "chamber_1_pressure", "chamber_2_pressure", "piston_position", "input_voltage"


def made_up_records(
    n_healthy=400, n_other=60, severities=SEVERITIES, shifts=("stiffer", "much stiffer"),
    confusions=("worn friction",),
):  # fmt: skip
    """Records of made-up populations; the true leakage scatters by 5 % about the nominal one."""
    levels = [Population(f"{q:.2g} L/min", Kind.FAULT, severity=q * LITRES_PER_MINUTE) for q in severities]
    sizes = {FIT: n_healthy, TEST: n_healthy, **dict.fromkeys(levels, n_other)}
    sizes |= {Population(name, Kind.SHIFT): 340 for name in shifts}
    sizes |= {Population(name, Kind.CONFUSION): n_other for name in confusions}
    design = {"record.duration": 20.0, "record.sampling_frequency": 500.0}
    return replace(study(sizes, 0.05), severity_unit="m^3/s", design=design)


def made_up_score(records, name, *, gain, shift=0.0, seed=0, missing=0.0, **described):
    """A standard normal score that grows by `gain` per L/min, and by `shift` in shifts and confusions.

    Some sound records are missing.
    """
    drawn = np.random.default_rng(seed)
    kinds = np.array([one.kind in (Kind.SHIFT, Kind.CONFUSION) for one in records.populations])
    values = drawn.normal(size=records.of_record.size) + gain * records.severity / LITRES_PER_MINUTE
    values = values + shift * kinds[records.of_record]
    sound = np.array([one.kind is not Kind.FAULT for one in records.populations])[records.of_record]
    values[sound & (drawn.random(values.size) < missing)] = np.nan
    return Scored(name, values, **{"direction": Direction.RISING, **described})


def made_up_scores(records):
    """Seven scores: two good ones, two that shifts spoil, one with holes, and two wavelet rules."""
    rest = {"channels": (P1,), "cost": 1.6e-3}
    balance, pressures = {"channels": (P1, P2, X, U), "cost": 4e-3}, {"channels": (P1, P2, U), "cost": 4e-3}
    return (
        made_up_score(records, "flow_balance.leakage_coefficient", gain=200.0, seed=1, **balance),
        made_up_score(records, "flow_balance.bulk_modulus", gain=0.0, shift=6.0, seed=2, **balance),
        made_up_score(records, "pressure_balance.leakage_flow", gain=80.0, seed=3, **pressures),
        made_up_score(records, "pressure_statistics.kurtosis", gain=10.0, shift=1.0, seed=4, **rest),
        made_up_score(records, "ring_down.damping_ratio", gain=6.0, seed=5, missing=0.05, **rest),
        made_up_score(records, "dwt.d2", gain=-1.0, seed=6, direction=Direction.FALLING, unit="Pa", **rest),
        made_up_score(records, "dwt.d3", gain=0.5, seed=7, direction=None, unit="Pa", **rest),
    )


def judged(scores=made_up_scores, **chosen):
    """A study that is judged; `chosen` says which records it has."""
    records = made_up_records(**chosen)
    return detect(records, scores(records), Rules())


def report_of(detection):
    return DetectionReport((detection,))
