"""An experiment looked at before it is run: step, mode and bands, record, leakage, stroke."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrofdi.assessment.observability import Observability, observability
from hydrofdi.assessment.plan_warnings import (
    NEAR_BAND_EDGE,
    few_of,
    folding_warnings,
    measures_wavelets,
    near_edge_warnings,
    period_count,
    place_in_bands,
    record_warnings,
)
from hydrofdi.assessment.selection import Selection, computed_rows
from hydrofdi.assessment.sensor_noise import MUCH_NOISE, NoiseOfLevel, noise_of_levels
from hydrofdi.assessment.step_limits import shortest_step_limits, step_limits, too_long_sentence
from hydrofdi.config.sections.record import RecordConfig
from hydrofdi.config.shown_values import shown_value
from hydrofdi.execution import Job
from hydrofdi.physics.hydraulic_mode import HydraulicMode
from hydrofdi.physics.leakage import internal_leakage_flow
from hydrofdi.settings.counting import counted
from hydrofdi.store.layout.names import OBSTACLE
from hydrofdi.transforms.wavelet import boundary_shares, level_bands

REFERENCE_DROP = 8e6
"""Pressure difference at which a leak is also stated, by default by indicators as well [Pa]."""

FULL_STROKE = 0.9
"""Share of the stroke from which on the linearised mode, taken at the centre, is off by far."""

_REMEDY_OF_BANDS = (
    "Another record.sampling_frequency moves the bands; the undecimated transform (modwt) has the same ones"
)


@dataclass(frozen=True)
class ModeOfRun:
    """One run.

    Attributes
    ----------
    labels : dict
        Further varied parameters → their values in SI.
    bulk_modulus, leakage_coefficient : float
        β [Pa] and K_i [m^3.5/kg^0.5].
    mean_leakage_flow, leakage_flow_at_reference : float
        Mean of abs(q_il), and q_il at 8 MPa [m³/s].
    piston_share : float
        Mean leakage flow over the mean of A abs(v_p) [-].
    frequency, damping_ratio : float
        f_h [Hz] and ζ [-].
    level : int
        Level whose band holds f_h; 0 above d1, one more than there are below all.
    octaves_to_edge : float
        Distance of f_h from the nearest edge of a band.
    stroke_share : float
        Largest abs(x_p) over V/A [-].
    status, verdict : str
    """

    labels: dict[str, Any]
    bulk_modulus: float
    leakage_coefficient: float
    mean_leakage_flow: float
    leakage_flow_at_reference: float
    piston_share: float
    frequency: float
    damping_ratio: float
    level: int
    octaves_to_edge: float
    stroke_share: float
    status: str
    verdict: str


@dataclass(frozen=True)
class Inspection:
    """What an inspection found.

    Attributes
    ----------
    step : float
        Runge-Kutta step [s].
    step_limits : dict
        Part of the model → longest stable step over all runs [s].
    modes : tuple of ModeOfRun
    bands : tuple of (float, float)
        Band of each level [Hz].
    n_sample : int
    n_period : float
        Periods of the input in the record; NaN if it has none.
    boundary_shares : tuple of float
        Share of each level's coefficients that depend on the extension of the record [-].
    noise : tuple of NoiseOfLevel
        Noise of the chamber-1 pressure sensor; empty if it has none.
    folding : tuple of str
        Sentences on inputs and anti-alias filters that are too fast for the sampling.
    n_left_out : int
        Distinct runs of the experiment that are not among the modes.
    sampling_frequency : float
        Of the record [Hz].
    observability : tuple of Observability
        What the first run, without a leak, tells each indicator that estimates unknowns.
    unmeasured : tuple of str
        Sentences on indicators without numbers of some runs, and why.
    has_wavelets : bool
        Whether an indicator has the bands of a wavelet transform.
    """

    step: float
    step_limits: dict[str, float]
    modes: tuple[ModeOfRun, ...]
    bands: tuple[tuple[float, float], ...]
    n_sample: int
    n_period: float
    boundary_shares: tuple[float, ...]
    noise: tuple[NoiseOfLevel, ...]
    folding: tuple[str, ...]
    n_left_out: int = 0
    sampling_frequency: float = RecordConfig().sampling_frequency
    observability: tuple[Observability, ...] = ()
    unmeasured: tuple[str, ...] = ()
    has_wavelets: bool = True

    @property
    def binding(self) -> str:
        """The part of the model that allows the shortest step only."""
        return min(self.step_limits, key=self.step_limits.__getitem__)

    @property
    def problems(self) -> list[str]:
        """What makes results wrong."""
        return list(dict.fromkeys(_problems(self)))

    @property
    def warnings(self) -> list[str]:
        """Warnings about the results."""
        return list(dict.fromkeys(_warnings(self)))


def inspect_experiment(selection: Selection) -> Inspection:
    """Inspect the runs of an experiment; those selected are simulated once.

    Parameters
    ----------
    selection : Selection
        At least one run. Step limits, sensors and inputs of all other runs count as well.
    """
    jobs, distinct = selection.jobs, selection.distinct
    rows = computed_rows(jobs)
    nominal, analysis = jobs[0].parameters, jobs[0].analysis
    record, wavelet = nominal.record, analysis.wavelet
    bands = tuple(level_bands(record.sampling_frequency, wavelet.levels))
    modes = [_mode_of_run(job, row, bands, selection.labels) for job, row in zip(jobs, rows, strict=True)]
    limits = [_limits(job, mode) for job, mode in zip(jobs, modes, strict=True)]
    limits.append(shortest_step_limits(distinct))
    return Inspection(
        step=max(job.parameters.record.step for job in jobs),
        step_limits=_shortest(limits),
        modes=tuple(modes),
        bands=bands,
        n_sample=record.n_sample,
        n_period=period_count(nominal),
        boundary_shares=tuple(boundary_shares(record.n_sample - analysis.n_discarded, wavelet)),
        noise=noise_of_levels(distinct("wavelet", "pressure_1_sensor", "measurement", "record"), rows),
        folding=tuple(folding_warnings(distinct)),
        n_left_out=selection.n_left_out,
        sampling_frequency=record.sampling_frequency,
        observability=observability(jobs[0]),
        unmeasured=tuple(_unmeasured(jobs, rows)),
        has_wavelets=measures_wavelets(analysis.choice),
    )


def _unmeasured(jobs: Sequence[Job], rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """A sentence on each reason for which an indicator has no numbers of runs that are computed."""
    reasons = Counter(
        (label, str(row[f"{label}{OBSTACLE}"]))
        for job, row in zip(jobs, rows, strict=True)
        if row["status"] == "ok"
        for label in job.analysis.indicators
    )
    for (label, reason), count in reasons.items():
        if reason:
            yield f"{label} has no numbers in {count} of {counted(len(rows), 'run')}: {reason}"


def _shortest(limits: Iterable[dict[str, float]]) -> dict[str, float]:
    shortest: dict[str, float] = {}
    for part, limit in (item for each in limits for item in each.items()):
        shortest[part] = min(limit, shortest.get(part, math.inf))
    return shortest


def _limits(job: Job, mode: ModeOfRun) -> dict[str, float]:
    is_known = math.isfinite(mode.frequency) and math.isfinite(mode.damping_ratio)
    return step_limits(
        job.parameters, HydraulicMode(mode.frequency, mode.damping_ratio) if is_known else None
    )


def _mode_of_run(
    job: Job, row: Mapping[str, Any], bands: Sequence[tuple[float, float]], labels: Sequence[str]
) -> ModeOfRun:
    actuator = job.parameters.actuator
    stroke = actuator.chamber_volume / actuator.piston_area
    mean, frequency = float(row["mean_internal_leakage_flow"]), float(row["hydraulic_mode_frequency"])
    piston_flow = actuator.piston_area * float(np.mean(np.abs(row["piston_velocity"])))
    furthest = max(abs(float(row[f"piston_position_{end}"])) for end in ("min", "max"))
    level, octaves = place_in_bands(frequency, bands)
    return ModeOfRun(
        labels={name: job.parameters.shown_value(name) for name in labels},
        bulk_modulus=job.parameters.fluid.bulk_modulus,
        leakage_coefficient=job.leakage_coefficient,
        mean_leakage_flow=mean,
        leakage_flow_at_reference=float(internal_leakage_flow(REFERENCE_DROP, job.leakage_coefficient)),
        piston_share=mean / piston_flow if piston_flow else math.nan,
        frequency=frequency,
        damping_ratio=float(row["hydraulic_mode_damping_ratio"]),
        level=level,
        octaves_to_edge=octaves,
        stroke_share=furthest / stroke,
        status=str(row["status"]),
        verdict=str(row["verdict"]),
    )


def _problems(found: Inspection) -> Iterator[str]:
    for part, limit in found.step_limits.items():
        if found.step > limit:
            yield too_long_sentence(part, found.step, limit, found.sampling_frequency)
    failed: dict[str, list[str]] = {}
    for mode in (mode for mode in found.modes if mode.status != "ok"):
        modulus = shown_value("fluid.bulk_modulus", mode.bulk_modulus)
        condition = f"EBM {modulus} with K_i {mode.leakage_coefficient:.3g}"
        failed.setdefault(mode.status, []).append(condition)
    for status, conditions in failed.items():
        yield f"{status}: {len(conditions)} of {counted(len(found.modes), 'run')}, at {few_of(conditions)}"


def _warnings(found: Inspection) -> Iterator[str]:
    modes = {(mode.frequency, mode.bulk_modulus): mode for mode in found.modes}
    near = (key for key, mode in modes.items() if mode.octaves_to_edge < NEAR_BAND_EDGE)
    if found.has_wavelets:
        yield from (f"{text}. {_REMEDY_OF_BANDS}" for text in near_edge_warnings(near, len(modes)))
    yield from found.folding
    yield from found.unmeasured
    yield from record_warnings(found.n_period, found.boundary_shares)
    for level, noise in enumerate(found.noise, 1):
        if noise.share > MUCH_NOISE:
            yield (
                f"sensor noise is {noise.share:.0%} of the weakest run's d{level}"
                f" and raises its RMS by {math.hypot(1.0, noise.share) - 1.0:.1%}"
            )
    fullest = max((mode.stroke_share for mode in found.modes if mode.status == "ok"), default=0.0)
    if fullest > FULL_STROKE:
        yield f"{fullest:.0%} of the stroke is used; a chamber all but vanishes"
    for word in sorted({mode.verdict for mode in found.modes if mode.status == "ok"} - {"ok"}):
        count = sum(mode.verdict == word for mode in found.modes)
        yield f"{word}: {count} of {counted(len(found.modes), 'run')}"
