"""An experiment looked at before it is run: step, mode and bands, record, leakage, stroke, sensor noise."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from hydrofdi.api.selection import Selection, computed_rows
from hydrofdi.api.step_limits import shortest_step_limits, step_limits, too_long_sentence
from hydrofdi.api.warnings import period_count, place_in_bands
from hydrofdi.config import RunParameters
from hydrofdi.config.request import RunRequest
from hydrofdi.config.shown_values import shown_value
from hydrofdi.execution import Job
from hydrofdi.indicators.information import Information, Informative, Unknown
from hydrofdi.indicators.measuring import seen_by
from hydrofdi.physics.hydraulic_mode import HydraulicMode
from hydrofdi.physics.leakage import REFERENCE_DROP, internal_leakage_flow
from hydrofdi.records import RecordBatch
from hydrofdi.sensing import noise_autocovariance, quantisation_noise
from hydrofdi.settings.counting import counted
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.store.layout.names import OBSTACLE
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period
from hydrofdi.transforms.wavelet import boundary_shares, level_bands, noise_rms

FULL_STROKE = 0.9
"""Share of the stroke from which on the linearised mode, taken at the centre, is off by far."""

MUCH_NOISE = 0.1
"""Noise above this share of a level's RMS is warned of; it adds half a percent to that RMS."""

_FEW = 3


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
class NoiseOfLevel:
    """One level of the chamber-1 pressure.

    Attributes
    ----------
    noise : float
        RMS of the detail coefficients of the sensor's noise, as the anti-alias filter leaves it, and of
        quantisation, of the noisiest run [Pa].
    weakest_rms : float
        Least detail RMS of the pressure itself over the runs that ended well [Pa]; NaN if none did.
    """

    noise: float
    weakest_rms: float

    @property
    def share(self) -> float:
        """Noise over the least RMS [-]."""
        return self.noise / self.weakest_rms if self.weakest_rms else math.inf


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
    n_left_out : int
        Distinct runs of the experiment that are not among the modes.
    sampling_frequency : float
        Of the record [Hz].
    observability : tuple of Observability
        What the first run, without a leak, tells each indicator that estimates unknowns.
    problems, warnings : tuple of str
        What makes results wrong, and what to keep in mind when reading them.
    """

    step: float
    step_limits: dict[str, float]
    modes: tuple[ModeOfRun, ...]
    bands: tuple[tuple[float, float], ...]
    n_sample: int
    n_period: float
    boundary_shares: tuple[float, ...]
    noise: tuple[NoiseOfLevel, ...]
    n_left_out: int
    sampling_frequency: float
    observability: tuple[Observability, ...]
    problems: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def binding(self) -> str:
        """The part of the model that allows the shortest step only."""
        return min(self.step_limits, key=self.step_limits.__getitem__)


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
    step, limits = max(job.parameters.record.step for job in jobs), shortest_step_limits(distinct)
    for job, mode in zip(jobs, modes, strict=True):
        is_known = math.isfinite(mode.frequency) and math.isfinite(mode.damping_ratio)
        found = HydraulicMode(mode.frequency, mode.damping_ratio) if is_known else None
        for part, limit in step_limits(job.parameters, found).items():
            limits[part] = min(limit, limits.get(part, math.inf))
    noise = noise_of_levels(distinct("wavelet", "pressure_1_sensor", "measurement", "record"), rows)
    too_long = [
        too_long_sentence(part, step, limit, record.sampling_frequency)
        for part, limit in limits.items()
        if step > limit
    ]
    warnings = [*_unmeasured(jobs, rows), *_noise_warnings(noise), *_verdict_warnings(modes)]
    return Inspection(
        step=step,
        step_limits=limits,
        modes=tuple(modes),
        bands=bands,
        n_sample=record.n_sample,
        n_period=period_count(nominal),
        boundary_shares=tuple(boundary_shares(record.n_sample - analysis.n_discarded, wavelet)),
        noise=noise,
        n_left_out=selection.n_left_out,
        sampling_frequency=record.sampling_frequency,
        observability=observability(jobs[0]),
        problems=tuple(dict.fromkeys([*too_long, *_failures(modes)])),
        warnings=tuple(dict.fromkeys(warnings)),
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


def noise_of_levels(
    runs: Iterable[RunRequest], rows: Sequence[Mapping[str, Any]]
) -> tuple[NoiseOfLevel, ...]:
    """Noise of sensors of runs against computed rows with ideal ones, d1 first; empty if none is noisy."""
    noises = {(run.wavelet, _autocovariance(run)) for run in runs}
    if not any(noise[0] for _, noise in noises):
        return ()
    levels = min(wavelet.levels for wavelet, _ in noises)
    noisiest = np.max([noise_rms(wavelet, noise)[:levels] for wavelet, noise in noises], axis=0)
    signals = np.array([row["detail_rms"][:levels] for row in rows if row["status"] == "ok"])
    weakest = signals.min(axis=0) if len(signals) else np.full(levels, np.nan)
    return tuple(NoiseOfLevel(float(noisiest[level]), float(weakest[level])) for level in range(levels))


def _autocovariance(run: RunParameters) -> tuple[float, ...]:
    """Autocovariance of noise and quantisation in the chamber-1 pressure [Pa²]."""
    sensor = run.pressure_1_sensor
    variance, *others = noise_autocovariance(sensor, run.measurement, run.record)
    return variance + quantisation_noise(sensor.resolution) ** 2, *others


def _failures(modes: Sequence[ModeOfRun]) -> Iterator[str]:
    failed: dict[str, list[str]] = {}
    for mode in (mode for mode in modes if mode.status != "ok"):
        modulus = shown_value("fluid.bulk_modulus", mode.bulk_modulus)
        condition = f"EBM {modulus} with K_i {mode.leakage_coefficient:.3g}"
        failed.setdefault(mode.status, []).append(condition)
    for status, conditions in failed.items():
        different = ", ".join([*dict.fromkeys(conditions)][:_FEW])
        yield f"{status}: {len(conditions)} of {counted(len(modes), 'run')}, such as at {different}"


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


def _noise_warnings(noise: Sequence[NoiseOfLevel]) -> Iterator[str]:
    for level, each in enumerate(noise, 1):
        if each.share > MUCH_NOISE:
            yield (
                f"sensor noise is {each.share:.0%} of the weakest run's d{level}"
                f" and raises its RMS by {math.hypot(1.0, each.share) - 1.0:.1%}"
            )


def _verdict_warnings(modes: Sequence[ModeOfRun]) -> Iterator[str]:
    ended = [mode for mode in modes if mode.status == "ok"]
    fullest = max((mode.stroke_share for mode in ended), default=0.0)
    if fullest > FULL_STROKE:
        yield f"{fullest:.0%} of the stroke is used; a chamber all but vanishes"
    for word, count in sorted(Counter(mode.verdict for mode in ended).items()):
        if word != "ok":
            yield f"{word}: {count} of {counted(len(modes), 'run')}"


LONGEST, COLLINEAR, _NOTABLE = 20.0, 0.95, 0.3
"""What is looked at of a record [s]; correlation of collinear unknowns; parts of a direction with a name."""


@dataclass(frozen=True)
class Observability:
    """What a healthy record of a duration [s] tells an estimator; empty if its estimate diverges along it.

    `weakest` is the direction of the parameters that is known least, and `weakest_left` its deviation over
    that beforehand. `collinear` lists pairs whose errors behind the record are correlated.
    """

    indicator: str
    duration: float
    weakest: str = ""
    weakest_left: float = math.nan
    unknowns: tuple[Unknown, ...] = ()
    collinear: tuple[tuple[str, str, float], ...] = ()


def observability(job: Job) -> tuple[Observability, ...]:
    """What a run without a leak, up to 20 s of it, tells each indicator that has unknowns."""
    made, run = job.analysis.indicators, job.parameters
    estimators = {label: each for label, each in made.items() if isinstance(each, Informative)}
    if not estimators or not (trajectory := simulate_batch([run], [0.0])).outcomes[0].is_ok:
        return ()
    frequency, first = run.record.sampling_frequency, job.analysis.n_discarded
    signals = {channel: getattr(trajectory, signal) for channel, signal in SIGNAL_OF_CHANNEL.items()}
    period = drive_period(run.input, run.load.random_force)
    record = RecordBatch(signals, frequency, ("",), drive_period=period)
    record = record.window(first, first + round(LONGEST * frequency))
    return tuple(
        _described(label, record.duration, each.information(seen_by(each, record)))
        for label, each in estimators.items()
        if each.obstacle(record) is None
    )


def _described(label: str, duration: float, found: Information) -> Observability:
    if not np.isfinite(found.covariance).all():
        return Observability(label, duration)
    unknowns, deviations = found.unknowns, np.sqrt(np.diag(found.covariance))
    values, directions = np.linalg.eigh(found.covariance[found.n_motion :, found.n_motion :])
    least_known = directions[:, -1] * np.sign(directions[np.abs(directions[:, -1]).argmax(), -1])
    names = (each.name for each in unknowns[found.n_motion :])
    weakest = sorted(zip(names, least_known.tolist(), strict=True), key=lambda part: -abs(part[1]))
    correlated = found.covariance / np.outer(deviations, deviations)
    return Observability(
        label,
        duration,
        ", ".join(f"{name} {share:.2f}" for name, share in weakest if abs(share) >= _NOTABLE),
        math.sqrt(values[-1]),
        unknowns,
        tuple(
            (unknowns[i].name, unknowns[j].name, float(correlated[i, j]))
            for i, j in combinations(range(len(unknowns)), 2)
            if abs(correlated[i, j]) > COLLINEAR
        ),
    )
