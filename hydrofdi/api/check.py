"""Checks of an experiment before it runs, and leakage coefficients of leakage flows, with their tables."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import combinations
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.api.arguments import positive_of
from hydrofdi.api.step_limits import Distinct, lag_limit, step_limits, too_long_sentence
from hydrofdi.api.warnings import experiment_warnings, period_count, place_in_bands
from hydrofdi.config import ExperimentConfig, RunParameters, expand_runs
from hydrofdi.config.loading import Experiment, load_experiment
from hydrofdi.config.request import OBSERVATION, SENSING, RunRequest
from hydrofdi.config.run_table.runs import Runs
from hydrofdi.config.shown_values import shown_in, shown_value
from hydrofdi.config.study.table import StudyTable
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.errors import ConfigError
from hydrofdi.execution import InProcessEngine, Job, compute_columns, leakage_coefficients
from hydrofdi.indicators.contract import Information, Informative, Unknown
from hydrofdi.indicators.measuring import seen_by
from hydrofdi.physics.leakage import REFERENCE_DROP, internal_leakage_flow
from hydrofdi.records import RecordBatch
from hydrofdi.report.table import Column, Table, plain, quantity
from hydrofdi.report.wording import labels_text, shown_modulus
from hydrofdi.sensing import noise_autocovariance, quantisation_noise
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, readable_unit, two_digits, typeset
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.kernels.lanes import WIDTH
from hydrofdi.store.layout.names import OBSTACLE
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period
from hydrofdi.transforms.wavelet import boundary_shares, level_bands, noise_rms
from hydrofdi.units import convert

_MOST_ROWS = 24
"""Most runs that have a row each; for more, such as a sample, the ranges are shown."""

FULL_STROKE = 0.9
"""Share of the stroke from which on the linearised mode, taken at the centre, is off by far."""

MUCH_NOISE = 0.1
"""Noise above this share of a level's RMS is warned of; it adds half a percent to that RMS."""

_FEW = 3


Mode = dict[str, Any]
"""One run: ``labels``, further varied parameters → their values in SI; ``bulk_modulus`` [Pa];
``leakage_coefficient`` K_i [m^3.5/kg^0.5]; ``mean_leakage_flow`` of abs(q_il), and
``leakage_flow_at_reference``, q_il at 8 MPa [m³/s]; ``piston_share``, mean leakage flow over the mean of
A abs(v_p) [-]; ``frequency`` f_h [Hz] and ``damping_ratio`` ζ [-]; ``level`` whose band holds f_h, 0 above
d1, one more than there are below all; ``octaves_to_edge``, distance of f_h from the nearest edge of a band;
``stroke_share``, largest abs(x_p) over V/A [-]; ``status`` and ``verdict``."""


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


@dataclass(frozen=True, repr=False)
class Check:
    """Findings on an experiment, as `hydrofdi.check` returns them. True if there are no problems.

    Attributes
    ----------
    step : float
        Runge-Kutta step [s].
    step_limits : dict
        Part of the model → longest stable step over all runs [s].
    modes : tuple of dict
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
    problems, warnings : list of str
        What makes results wrong, and what to keep in mind when reading them.
    convergence : Convergence or None
        Change of the features when the step is halved; None if this was not requested.
    """

    step: float
    step_limits: dict[str, float]
    modes: tuple[Mode, ...]
    bands: tuple[tuple[float, float], ...]
    n_sample: int
    n_period: float
    boundary_shares: tuple[float, ...]
    noise: tuple[NoiseOfLevel, ...]
    n_left_out: int
    sampling_frequency: float
    observability: tuple[Observability, ...]
    problems: list[str]
    warnings: list[str]
    convergence: Convergence | None = None

    @property
    def binding(self) -> str:
        """The part of the model that allows the shortest step only."""
        return min(self.step_limits, key=self.step_limits.__getitem__)

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi check --json`` prints; None in place of what is not finite."""
        record = asdict(self) | {"binding": self.binding}
        if self.convergence is None:
            del record["convergence"]
        else:
            record["convergence"]["good_enough"] = self.convergence.good_enough
        cleaned: dict[str, Any] = plain(record)
        return cleaned

    def __bool__(self) -> bool:
        return not self.problems

    def __repr__(self) -> str:
        lines = [f"problem: {each}" for each in self.problems]
        return "\n".join([*lines, *(f"warning: {each}" for each in self.warnings)] or ["no warnings"])


def check(
    experiment: Experiment | None = None,
    /,
    *,
    halve_step: bool = False,
    tolerance: float = 1e-3,
    **settings: Any,
) -> Check:
    """Look at an experiment before running it, as ``hydrofdi check`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        By default the nominal actuator.
    halve_step : bool
        Whether to halve the step until the detail RMS no longer change.
    tolerance : float
        Accepted relative change of a detail RMS.
    **settings
        As in `hydrofdi.simulate`.

    Raises
    ------
    ConfigError
        With every mistake, or a leakage flow that cannot be reached.

    Examples
    --------
    >>> import hydrofdi
    >>> found = hydrofdi.check(duration="2 s", step="1 ms")
    >>> bool(found)
    False
    >>> found.problems[0]
    'the step of 0.001 s is too long for the friction zone: ...'
    """
    accepted = positive_of("tolerance", tolerance, "1", "a relative change such as 0.001")
    loaded = load_experiment(experiment, settings)
    selection = select_runs(loaded)
    with shown_in(loaded.units):
        return inspect_experiment(
            selection,
            converge(selection.jobs, accepted) if halve_step else None,
            experiment_warnings(loaded, selection.distinct),
        )


def calibrate(
    experiment: Experiment | None = None,
    /,
    *,
    flows: str | float | Sequence[str | float] = (),
    **settings: Any,
) -> list[LeakageTarget]:
    """The leakage coefficients of mean leakage flows, under the conditions of the baseline.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        By default the nominal actuator.
    flows : str, float, or sequence of them
        Mean leakage flows such as ``"0.12 L/min"``, or numbers in SI [m³/s].
    **settings
        As in `hydrofdi.simulate`.

    Raises
    ------
    ConfigError
        With every mistake, or a flow that cannot be reached.

    Examples
    --------
    >>> import hydrofdi
    >>> (target,) = hydrofdi.calibrate(flows=["0.12 L/min"], duration="2 s")
    >>> f"{target.coefficient:.1e} m³/s/√Pa"
    '...e-10 m³/s/√Pa'
    """
    if isinstance(flows, str | Real) or not isinstance(flows, Iterable):
        flows = [flows]
    what = "a flow such as '0.12 L/min', or a number in m³/s"
    values = [positive_of("flows", flow, "m^3/s", what) for flow in flows]
    if not values:
        raise ConfigError("flows: name at least one, e.g. 0.12 L/min")
    loaded = load_experiment(experiment, settings)
    sweep = SweepConfig(grid={"leakage.internal_flow": list(dict.fromkeys(values))})
    table = expand_runs(loaded.model_copy(update={"sweep": sweep}))
    runs = table.runs[: table.n_swept]
    coefficients = leakage_coefficients(runs, InProcessEngine(), {})
    jobs = [Job(str(k), run.calibration or run.parameters, coefficients[k]) for k, run in enumerate(runs)]
    targets = []
    for job, row in zip(jobs, computed_rows(jobs), strict=True):
        mean = float(row["mean_internal_leakage_flow"])
        difference = np.mean(np.abs(row["chamber_1_pressure"] - row["chamber_2_pressure"]))
        piston = job.parameters.actuator.piston_area * np.mean(np.abs(row["piston_velocity"]))
        targets.append(
            LeakageTarget(mean, job.leakage_coefficient, float(mean / difference), float(mean / piston))
        )
    return targets


def inspect_experiment(
    selection: Selection, convergence: Convergence | None = None, settings: Iterable[str] = ()
) -> Check:
    """Inspect the runs of an experiment; those selected are simulated once.

    Parameters
    ----------
    selection : Selection
        At least one run. Step limits, sensors and inputs of all other runs count as well.
    convergence : Convergence, optional
        Belongs to the result.
    settings : iterable of str
        Warnings of the settings.
    """
    jobs, distinct = selection.jobs, selection.distinct
    rows = computed_rows(jobs)
    nominal, analysis = jobs[0].parameters, jobs[0].analysis
    record, wavelet = nominal.record, analysis.wavelet
    bands = tuple(level_bands(record.sampling_frequency, wavelet.levels))
    modes = [_mode_of_run(job, row, bands, selection.labels) for job, row in zip(jobs, rows, strict=True)]
    step, limits = max(job.parameters.record.step for job in jobs), step_limits(distinct)
    for mode in modes:
        if math.isfinite(mode["frequency"]) and math.isfinite(mode["damping_ratio"]):
            limit = lag_limit(2.0 * math.pi * mode["frequency"], mode["damping_ratio"])
            limits["hydraulic mode"] = min(limit, limits["hydraulic mode"])
    noise = noise_of_levels(distinct("wavelet", "pressure_1_sensor", "measurement", "record"), rows)
    too_long = [
        too_long_sentence(part, step, limit, record.sampling_frequency)
        for part, limit in limits.items()
        if step > limit
    ]
    problems = [*too_long, *_failures(modes)]
    if convergence is not None and convergence.good_enough is None:
        problems.append("none of the tested steps is short enough")
    warnings = [*settings, *_unmeasured(jobs, rows), *_noise_warnings(noise), *_verdict_warnings(modes)]
    return Check(
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
        problems=list(dict.fromkeys(problems)),
        warnings=list(dict.fromkeys(warnings)),
        convergence=convergence,
    )


def _mode_of_run(
    job: Job, row: Mapping[str, Any], bands: Sequence[tuple[float, float]], labels: Sequence[str]
) -> Mode:
    actuator = job.parameters.actuator
    stroke = actuator.chamber_volume / actuator.piston_area
    mean, frequency = float(row["mean_internal_leakage_flow"]), float(row["hydraulic_mode_frequency"])
    piston_flow = actuator.piston_area * float(np.mean(np.abs(row["piston_velocity"])))
    furthest = max(abs(float(row[f"piston_position_{end}"])) for end in ("min", "max"))
    level, octaves = place_in_bands(frequency, bands)
    return {
        "labels": {name: job.parameters.shown_value(name) for name in labels},
        "bulk_modulus": job.parameters.fluid.bulk_modulus,
        "leakage_coefficient": job.leakage_coefficient,
        "mean_leakage_flow": mean,
        "leakage_flow_at_reference": float(internal_leakage_flow(REFERENCE_DROP, job.leakage_coefficient)),
        "piston_share": mean / piston_flow if piston_flow else math.nan,
        "frequency": frequency,
        "damping_ratio": float(row["hydraulic_mode_damping_ratio"]),
        "level": level,
        "octaves_to_edge": octaves,
        "stroke_share": furthest / stroke,
        "status": str(row["status"]),
        "verdict": str(row["verdict"]),
    }


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


def _failures(modes: Sequence[Mode]) -> Iterator[str]:
    failed: dict[str, list[str]] = {}
    for mode in (mode for mode in modes if mode["status"] != "ok"):
        modulus = shown_value("fluid.bulk_modulus", mode["bulk_modulus"])
        condition = f"EBM {modulus} with K_i {mode['leakage_coefficient']:.3g}"
        failed.setdefault(mode["status"], []).append(condition)
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


def _verdict_warnings(modes: Sequence[Mode]) -> Iterator[str]:
    ended = [mode for mode in modes if mode["status"] == "ok"]
    fullest = max((mode["stroke_share"] for mode in ended), default=0.0)
    if fullest > FULL_STROKE:
        yield f"{fullest:.0%} of the stroke is used; a chamber all but vanishes"
    for word, count in sorted(Counter(mode["verdict"] for mode in ended).items()):
        if word != "ok":
            yield f"{word}: {count} of {counted(len(modes), 'run')}"


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


def modes_table(found: Check) -> Table:
    """The hydraulic mode of each run, or the ranges of many runs."""
    modes, modulus = found.modes, shown_modulus()
    n_band = len(found.bands)
    conditions = [labels_text(mode["labels"]) for mode in modes]
    has_conditions = len({*conditions}) > 1
    bands = [
        _band_name(mode["level"], n_band) if mode["status"] == "ok" else mode["status"] for mode in modes
    ]

    column = partial(_column, modes)
    columns = (
        column("bulk_modulus", "Pa", f"EBM [{modulus.unit}]", "g", modulus.number),
        column("leakage_coefficient", "m^3.5/kg^0.5", "K_i [m³/s/√Pa]", ".3g"),
        column("mean_leakage_flow", "m^3/s", "leakage [L/min]", ".3g", _litres),
        column("piston_share", "1", "piston flow", ".1%"),
        column("leakage_flow_at_reference", "m^3/s", "at 8 MPa [L/min]", ".3g", _litres),
        column("frequency", "Hz", "f_h [Hz]", ".1f"),
        column("damping_ratio", "1", "ζ", ".4f"),
        Column("band", bands),
        column("octaves_to_edge", "1", "octaves to edge", ".2f"),
        column("stroke_share", "1", "stroke used", ".0%"),
        Column("conditions", conditions, is_text=True, is_shown=has_conditions),
    )
    left = (f"left out: {counted(found.n_left_out, 'further run')}",) if found.n_left_out else ()
    if len(modes) <= _MOST_ROWS:
        return Table(columns, title="Hydraulic mode", n_lead=3, notes=left)
    names = Column("of_runs", ["least", "median", "largest"], title="of runs", is_text=True)
    numbers = [each for each in columns if each.unit]
    note = f"of {counted(len(modes), 'run')}; --json lists each"
    return Table((names, *map(_ranges, numbers)), title="Hydraulic mode", notes=(note, *left))


def _column(
    of: Sequence[Any], name: str, unit: str, title: str, form: str, shown: Callable[[float], float] = float
) -> Column:
    values = [each[name] for each in of]
    return Column(name, values, unit, title, lambda value: _text(shown(value), form))


def _ranges(column: Column) -> Column:
    finite = column.array[np.isfinite(column.array)]
    values = np.quantile(finite, [0.0, 0.5, 1.0]).tolist() if finite.size else [math.nan] * 3
    return Column(column.name, values, column.unit, column.title, column.text)


def _text(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else HOLE


def _litres(flow: float) -> float:
    return convert(flow, "L/min")


def _band_name(level: int, n_level: int) -> str:
    if level == 0:
        return "above d1"
    return f"d{level}" if level <= n_level else f"below d{n_level}"


def unknowns_table(found: Observability) -> Table:
    """Standard deviations of the unknowns of an estimator before and after a record, in readable units."""
    units = ["%" if each.unit == "1" else readable_unit(each.unit, each.before) for each in found.unknowns]
    scales = [
        convert(1.0, shown) if shown != each.unit else 1.0
        for each, shown in zip(found.unknowns, units, strict=True)
    ]

    def column(name: str) -> Column:
        values = [getattr(each, name) for each in found.unknowns]
        texts = [two_digits(value * scale) for value, scale in zip(values, scales, strict=True)]
        return Column(name, values, text=texts)

    return Table(
        (
            Column("unknown", [each.name for each in found.unknowns], is_text=True),
            column("before"),
            column("after"),
            Column("unit", [*map(typeset, units)], is_text=True),
        ),
        title=f"Standard deviations before and after {found.duration:g} s without a leak: {found.indicator}",
        notes=tuple(_told(found)),
    )


def _told(found: Observability) -> Iterator[str]:
    """The least known direction, and collinear pairs."""
    if not found.unknowns:
        yield "nothing: the estimate diverges; do its options fit the actuator?"
    elif all(each.after >= each.before for each in found.unknowns):
        yield "the record contains no information on them; does the valve open?"
    else:
        left = f"{found.weakest_left:.0%} of the prior deviation remains"
        yield f"least known: {found.weakest}: {left}"
        pairs = ", ".join(f"{one} and {other} ({value:+.3f})" for one, other, value in found.collinear)
        yield f"collinear: {pairs or 'none'}"


def noise_table(found: Check) -> Table:
    """Noise of the chamber-1 pressure sensor in each level, and its share of the weakest run."""
    levels = found.noise
    return Table(
        (
            Column("level", [f"d{level}" for level in range(1, len(levels) + 1)], is_text=True),
            quantity("noise", [each.noise for each in levels], "Pa"),
            quantity("weakest_rms", [each.weakest_rms for each in levels], "Pa", "weakest run"),
            Column("share", [each.share for each in levels], text=partial(_text, form=".1%")),
        ),
        title="Noise of the chamber-1 pressure sensor",
    )


def convergence_table(found: Convergence) -> Table:
    """The change of the features from step to step."""
    n_level = len(found.changes[0])
    end = (
        f"no step down to {found.steps[-1]:g} s stays within {found.tolerance:g}"
        if found.good_enough is None
        else f"a step of {convert(found.good_enough, 'ms'):g} ms stays within {found.tolerance:g}"
    )
    steps = Column("step", found.steps, "s", "step [ms]", lambda step: f"{convert(step, 'ms'):g}")
    levels = (
        Column(f"d{level}", [change[level - 1] for change in found.changes], text=partial(_text, form=".1e"))
        for level in range(1, n_level + 1)
    )
    title = "Largest change of the detail RMS when the step is halved"
    return Table((steps, *levels), title=title, notes=(end,))


def targets_table(targets: Sequence[LeakageTarget]) -> Table:
    """Leakage flows with their coefficients."""
    column = partial(_column, [asdict(each) for each in targets])
    return Table((
        column("flow", "m^3/s", "mean leakage [L/min]", ".4g", _litres),
        column("coefficient", "m^3.5/kg^0.5", "K_i (orifice) [m³/s/√Pa]", ".6g"),
        column("laminar_coefficient", "m^3/(s*Pa)", "laminar [m³/(s·Pa)]", ".4g"),
        column("piston_share", "1", "of piston flow", ".2%"),
    ))  # fmt: skip


MOST_RUNS, MOST_HALVINGS = 60, 6

_USUAL = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")


@dataclass(frozen=True)
class Selection:
    """Runs to look at.

    Attributes
    ----------
    jobs : list of Job
        Distinct runs with their K_i and ideal sensors.
    labels : tuple of str
        Varied parameters, besides EBM, internal leakage, sensors and analysis.
    n_left_out : int
        Number of further distinct runs.
    distinct : callable
        Gives one run of the experiment for each combination of sections that occurs.
    """

    jobs: list[Job]
    labels: tuple[str, ...]
    n_left_out: int
    distinct: Distinct


def select_runs(experiment: ExperimentConfig, most: int = MOST_RUNS) -> Selection:
    """The runs of an experiment that differ in more than sensors and analysis, up to a number.

    Where there are more, the first run of every EBM × leakage is chosen, then the first of every
    value of what varies besides; of a study, the first run of every population, then the second, and so on.
    In an ensemble, a leakage that cannot be reached is a run without K_i.

    Raises
    ------
    ConfigError
        A leakage flow cannot be reached.
    """
    table = expand_runs(experiment)
    labels = tuple(
        name for name in table.axes if name not in _USUAL and name.partition(".")[0] not in OBSERVATION
    )
    distinct = table.runs.first(*(name for name in RunParameters.model_fields if name not in SENSING))
    if table.study is None:
        ordered = _most_different(table.runs, labels, distinct)
    else:
        ordered = distinct[np.argsort(_places(table.study)[distinct], kind="stable")].tolist()
    chosen = sorted(ordered[:most])
    runs = list(table.runs.at(chosen))
    required = "none" if experiment.has_scenarios else "any"
    coefficients = leakage_coefficients(runs, InProcessEngine(), {}, required=required)  # type: ignore[arg-type]
    jobs = [
        Job(str(position), run.request.with_defaults(SENSING).parameters, coefficient, run.analysis)
        for position, (run, coefficient) in enumerate(zip(runs, coefficients, strict=True))
    ]
    return Selection(jobs, labels, len(distinct) - len(chosen), table.runs.distinct)


def _most_different(runs: Runs, labels: tuple[str, ...], distinct: NDArray[np.intp]) -> list[int]:
    """Positions of the runs that differ in more than their sensors, in the order in which they are chosen."""
    modes = runs.first("fluid", "leakage").tolist()
    others: dict[Any, int] = {}
    for position in runs.first(*{name.partition(".")[0] for name in labels}).tolist():
        others.setdefault(tuple(runs[position].parameters.shown_value(name) for name in labels), position)
    return list(dict.fromkeys([*modes, *others.values(), *distinct.tolist()]))


def _places(study: StudyTable) -> NDArray[np.intp]:
    """The place of each run in its population."""
    places = np.empty(len(study.of_run), dtype=np.intp)
    for population in range(len(study.populations)):
        own = np.flatnonzero(study.of_run == population)
        places[own] = np.arange(len(own))
    return places


def computed_rows(jobs: Sequence[Job]) -> list[dict[str, NDArray[np.float64]]]:
    """All variables of each job, in their order."""
    grids: dict[Any, list[Job]] = {}
    for job in jobs:
        grids.setdefault((job.parameters.record, job.analysis), []).append(job)
    rows: dict[str, dict[str, Any]] = {}
    for group in (
        all_[first : first + WIDTH] for all_ in grids.values() for first in range(0, len(all_), WIDTH)
    ):
        columns = compute_columns(group)
        for position, job in enumerate(group):
            rows[job.run_id] = {
                name: values[position] for name, values in columns.items() if len(values) == len(group)
            }
    return [rows[job.run_id] for job in jobs]


@dataclass(frozen=True)
class Convergence:
    """Features under halved steps.

    Attributes
    ----------
    tolerance : float
        Largest relative change that is accepted [-].
    steps : tuple of float
        The steps tried, longest first [s].
    changes : tuple of tuple of float
        For every step, the largest relative change of each detail RMS over the runs when it is halved; NaN
        where a run failed.
    """

    tolerance: float
    steps: tuple[float, ...]
    changes: tuple[tuple[float, ...], ...]

    @property
    def good_enough(self) -> float | None:
        """The longest step tried whose halving moves no feature beyond the tolerance; None: none of them."""
        pairs = zip(self.steps, self.changes, strict=True)
        return next((step for step, change in pairs if max(change) <= self.tolerance), None)


def converge(jobs: Sequence[Job], tolerance: float) -> Convergence:
    """Halve the step of runs until none of their detail RMS moves by more than a tolerance."""
    steps: list[float] = []
    changes: list[tuple[float, ...]] = []
    coarse = np.array([row["detail_rms"] for row in computed_rows(jobs)])
    while len(steps) < MOST_HALVINGS and not (changes and max(changes[-1]) <= tolerance):
        steps.append(step := jobs[0].parameters.record.step)
        half = {"record.step": 0.5 * step}
        jobs = [replace(job, parameters=job.parameters.with_values(half)) for job in jobs]
        fine = np.array([row["detail_rms"] for row in computed_rows(jobs)])
        changes.append(tuple(np.max(np.abs(coarse / fine - 1.0), axis=0).tolist()))
        coarse = fine
    return Convergence(tolerance, tuple(steps), tuple(changes))


@dataclass(frozen=True)
class LeakageTarget:
    """A mean leakage flow and the coefficients that cause it.

    Attributes
    ----------
    flow : float
        Mean of abs(q_il) [m³/s].
    coefficient : float
        K_i of the orifice law [m^3.5/kg^0.5].
    laminar_coefficient : float
        Mean of abs(q_il) over the mean of abs(P_1 − P_2) [m³/(s·Pa)].
    piston_share : float
        Mean of abs(q_il) over the mean of A abs(v_p) [-].
    """

    flow: float
    coefficient: float
    laminar_coefficient: float
    piston_share: float
