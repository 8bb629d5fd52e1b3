"""Calibration of leakage coefficients K_i to given mean leakage flows, of one run and of a whole sweep."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters, RunSpec
from hydrofdi.config.runs import PHYSICS_VERSION
from hydrofdi.config.values import shown_values, varied_parameters
from hydrofdi.engine import Engine, TaskFailure, halves, run_halving
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import shown_quantity
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.inputs import largest_leakage_flows, no_load_flow
from hydrofdi.simulation.lanes import WIDTH, positions_by

RELATIVE_TOLERANCE = 1e-10
"""Relative tolerance of K_i, by which a jump of the flow is told from a root. Solutions are closer."""

_LAST_STEPS = 1e-15
"""Product of the last two steps in ln K_i, to which the remaining error of a secant is proportional."""

_LARGEST_SURPLUS = 1e-6
"""Largest relative deviation of the leakage from the request; a root with more is rejected."""

_GROWTH, _FOREIGN_GROWTH = 3.0, 1000.0
"""Largest ratio of a K_i that is tried to those before; of FMUs, whose coefficients have any unit and law."""

_MOST_GROWN = 12
"""Number of K_i, each by that larger than the one before, after which a flow counts as unreachable."""

_LARGEST_LOGARITHM = 700.0
"""Largest ln K_i that is a number."""

_QUICK_TRIALS = 10
"""Number of trials after which every other one halves the bracket."""


@dataclass(frozen=True)
class Calibration:
    """Solution of one calibration.

    Attributes
    ----------
    coefficient : float
        K_i [m^3.5/kg^0.5]; NaN if no K_i gives the flow.
    reachable_flow : float
        Largest mean flow found during the search [m³/s].
    """

    coefficient: float
    reachable_flow: float


def solve_leakage_coefficients(conditions: Sequence[RunParameters]) -> list[Calibration]:
    """Solve for K_i such that the mean of abs(q_il) over the record equals ``leakage.internal_flow``.

    The conditions are solved in parallel lanes; no solution depends on the others.

    Parameters
    ----------
    conditions : sequence of RunParameters
        Runs with a positive internal flow.
    """
    searches = [search_coefficient(*_request(condition)) for condition in conditions]
    trials = {k: next(search) for k, search in enumerate(searches)}
    solutions: dict[int, Calibration] = {}
    while trials:
        open_conditions = list(trials)
        for group in positions_by(conditions[k].record for k in open_conditions).values():
            members = [open_conditions[position] for position in group]
            flows = _mean_flows([conditions[k] for k in members], [trials[k] for k in members])
            for k, flow in zip(members, flows.tolist(), strict=True):
                try:
                    trials[k] = searches[k].send(flow)
                except StopIteration as end:
                    solutions[k] = end.value
                    del trials[k]
    return [solutions[k] for k in range(len(conditions))]


def _request(condition: RunParameters) -> tuple[float, float, float]:
    """The flow of a condition, the K_i that leaks it at a quarter of the supply pressure, and its growth."""
    target, plant = condition.leakage.internal_flow or 0.0, condition.plant
    if plant.model is not None and plant.leakage.coefficient is not None:
        declared = plant.model.variables[plant.leakage.coefficient]
        # The size of an unknown law of leakage: that of its start value, if the FMU states one.
        start = abs(declared.in_si(declared.start)) if declared.start else target
        return target, start, _FOREIGN_GROWTH
    from_valve = no_load_flow(condition)
    # No more than the valve can feed: a larger K_i only equalises the pressures.
    start = min(target, from_valve) if from_valve > 0.0 else target
    return target, start / math.sqrt(0.25 * condition.supply.pressure), _GROWTH


def search_coefficient(
    target: float, trial: float, growth: float = _GROWTH
) -> Generator[float, float, Calibration]:
    """Trials of K_i, from a first one on, each answered by its mean flow; then the solution.

    A flow of NaN counts as too small. Secants of ln flow over ln K_i need few trials, as the flow is nearly
    proportional to K_i; a bracket guards them.
    """
    below, above, most = 0.0, math.inf, 0.0
    # A secant may go beyond the largest K_i tried, but not by more than the growth.
    ceiling, n_grown, n_trial = growth * trial, 0, 0
    points: list[tuple[float, float]] = []
    while math.isinf(above) or above - below > RELATIVE_TOLERANCE * above:
        flow = yield trial
        n_trial += 1
        most = max(most, 0.0 if math.isnan(flow) else flow)
        # A comparison with NaN is false, so a failed run raises the lower end of the bracket.
        below, above = (below, trial) if flow >= target else (trial, above)
        if flow > 0.0:
            points.append((math.log(trial), math.log(flow / target)))
        estimate, error = _secant(points[-2:])
        # Steps also shrink towards a jump of the flow, so the flow itself has to agree.
        if error < _LAST_STEPS and abs(flow / target - 1.0) < _LARGEST_SURPLUS:
            return Calibration(estimate, most)
        is_inside = below < estimate < min(above, ceiling)
        if math.isfinite(above):
            # Bisection in between bounds the number of trials if secants keep to one end of the bracket.
            halves = not is_inside or (n_trial > _QUICK_TRIALS and n_trial % 2 == 0)
            trial = 0.5 * (below + above) if halves else estimate
        elif is_inside:
            trial = estimate
        elif (n_grown := n_grown + 1) < _MOST_GROWN:
            trial, ceiling = ceiling, growth * ceiling
        else:
            break
    return Calibration(math.nan, most)


def _secant(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The K_i at which the secant of ln flow over ln K_i meets the request, and a measure of its error."""
    if not points:
        return math.nan, math.inf
    x, y = points[-1]
    before = points[0] if len(points) > 1 else (x - 1.0, y - 1.0)  # the flow is nearly proportional to K_i
    slope = (y - before[1]) / (x - before[0])
    if slope <= 0.0:
        return math.nan, math.inf
    # The error of a secant is proportional to the product of the step to come and the one before.
    return math.exp(min(x - y / slope, _LARGEST_LOGARITHM)), abs(y / slope * (x - before[0]))


def _mean_flows(runs: Sequence[RunParameters], coefficients: Sequence[float]) -> NDArray[np.float64]:
    """Mean leakage flows [m³/s]; NaN for runs that failed or chatter, as happens if K_i is very large."""
    trajectory = simulate_batch(runs, coefficients)
    flow = trajectory.mean_internal_leakage_flow
    failed = np.array([not outcome.is_ok for outcome in trajectory.outcomes])
    if runs[0].plant.fmu is not None:
        return np.where(failed, np.nan, flow)
    # More than continuity allows is an oscillation of the solver, not a leak.
    chatters = flow > largest_leakage_flows(runs, trajectory)
    return np.where(failed | chatters, np.nan, flow)


MOST_TRIALS = 30
"""Runs that a solution of K_i may take."""

_MOST_CONDITIONS = 8 * WIDTH
_SHOWN_MISTAKES = 10


def leakage_coefficients(
    runs: Sequence[RunSpec],
    engine: Engine | None = None,
    known: dict[str, float] | None = None,
    *,
    required: Literal["all", "any", "none"] = "all",
    on_solved: Callable[[int], None] = lambda _: None,
    lost: dict[int, TaskFailure] | None = None,
    time_per_job: float | None = None,
) -> list[float]:
    """K_i of each run [m^3.5/kg^0.5]: as given, or solved from the leakage flow.

    Parameters
    ----------
    engine : Engine, optional
        Where K_i are solved, by default this process.
    known : dict, optional
        Identity of a calibration → K_i; what is solved is added as it comes.
    required : {"all", "any", "none"}
        How many of the leaks have to be possible, else a ConfigError; a flow that no K_i reaches gives NaN.
    on_solved : callable
        Is told how many more are solved.
    lost : dict, optional
        Receives the position of each run whose K_i is NaN because its solution failed, and why.
    time_per_job : float, optional
        Wall time of one run [s]; a solution may take that of `MOST_TRIALS`.
    """
    engine, known = engine or Engine(), {} if known is None else known
    identities_of_runs, conditions = _conditions(runs)
    unsolved = tuple(item for item in conditions.items() if item[0] not in known)
    size = max(1, min(_MOST_CONDITIONS, -(-len(unsolved) // max(1, engine.workers))))
    if len(unsolved) > WIDTH:
        size = -(-size // WIDTH) * WIDTH
    groups = [unsolved[first : first + size] for first in range(0, len(unsolved), size)]
    reachable: dict[str, float] = {}
    failures: dict[str, TaskFailure] = {}

    def time_limit(group: Sequence[object]) -> float | None:
        return None if time_per_job is None else MOST_TRIALS * time_per_job * len(group)

    for result in run_halving(engine, _solve, groups, halves, time_limit):
        if result.failure is None:
            for (identity, _), solution in zip(result.item, result.value, strict=True):
                known[identity], reachable[identity] = solution.coefficient, solution.reachable_flow
        elif lost is None:
            raise RuntimeError(f"a calibration failed: {result.failure.message}") from result.failure.error
        else:
            failures |= {identity: result.failure for identity, _ in result.item}
        on_solved(len(result.item))
    if lost is not None:
        lost |= {k: failures[own] for k, own in enumerate(identities_of_runs) if own in failures}
    coefficients = [
        known.get(identity, math.nan) if identity else run.parameters.leakage.internal_coefficient or 0.0
        for run, identity in zip(runs, identities_of_runs, strict=True)
    ]
    if required == "all" or (required == "any" and not any(value > 0.0 for value in coefficients)):
        solved = {identity: condition for identity, condition in conditions.items() if identity in known}
        _require_reachable(solved, known, reachable)
    return coefficients


def calibration_identity(condition: RunParameters) -> str:
    """Hash of the conditions of a calibration and the physics version."""
    text = f"hydrofdi calibration, physics {PHYSICS_VERSION}\n{condition.text()}"
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def unsolved_conditions(runs: Sequence[RunSpec], known: dict[str, float]) -> int:
    """Number of calibrations that runs need and that are not known."""
    return len(_conditions(runs)[1].keys() - known.keys())


def _conditions(runs: Sequence[RunSpec]) -> tuple[list[str | None], dict[str, RunParameters]]:
    """The identity of each run's calibration, and the conditions of each identity."""
    conditions: dict[str, RunParameters] = {}
    identities: list[str | None] = []
    latest, identity = None, None
    for run in runs:
        if run.calibration is not latest:  # neighbours share theirs
            latest = run.calibration
            identity = None if latest is None else calibration_identity(latest)
        if identity is not None and latest is not None:
            conditions.setdefault(identity, latest)
        identities.append(identity)
    return identities, conditions


def _solve(group: Sequence[tuple[str, RunParameters]]) -> list[Calibration]:
    return solve_leakage_coefficients([condition for _, condition in group])


def _require_reachable(
    conditions: dict[str, RunParameters], known: dict[str, float], reachable: dict[str, float]
) -> None:
    unreachable = [identity for identity in conditions if math.isnan(known[identity])]
    if not unreachable:
        return
    varied = [name for name in varied_parameters(conditions.values()) if name != "leakage.internal_flow"]
    sentences = []
    for identity in unreachable:
        condition, most = conditions[identity], reachable.get(identity)
        setting = shown_values({name: condition.value(name) for name in varied})
        sentence = f"{unreachable_sentence(condition)}{' at ' if setting else ''}{setting}"
        if most is not None and most < (condition.leakage.internal_flow or 0.0):
            sentence += f"; the most that this actuator leaks is {shown_quantity(most, 'm^3/s', n_digit=3)}"
        elif most is not None:
            sentence += (
                ": the flow jumps across it as K_i grows; is the control loop unstable? Lower its gains"
            )
        sentences.append(sentence)
    distinct = list(dict.fromkeys(sentences))[:_SHOWN_MISTAKES]
    raise ConfigError([Issue(sentence, "leakage.internal_flow") for sentence in distinct])


def unreachable_sentence(condition: RunParameters) -> str:
    """What is wrong with a leakage flow that no K_i reaches."""
    flow = condition.leakage.internal_flow or 0.0
    return f"no K_i gives a mean leakage of {shown_quantity(flow, 'm^3/s')}"
