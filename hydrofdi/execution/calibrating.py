"""The leakage coefficients of the runs of a sweep."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from typing import Literal

from hydrofdi.config import RunParameters, RunSpec
from hydrofdi.config.shown_values import shown_values, varied_parameters
from hydrofdi.engine import Engine, TaskFailure, run_halving
from hydrofdi.errors import ConfigError, HydrofdiError, Issue
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.simulation.calibration import Calibration, solve_leakage_coefficients
from hydrofdi.simulation.lanes import WIDTH
from hydrofdi.units import convert

MOST_TRIALS = 30
"""Runs that a solution of K_i may take."""

_MOST_CONDITIONS = 8 * WIDTH
_SHOWN_MISTAKES = 10


def leakage_coefficients(
    runs: Sequence[RunSpec],
    engine: Engine,
    known: dict[str, float],
    *,
    required: Literal["all", "any", "none"] = "all",
    on_solved: Callable[[int], None] = lambda _: None,
    lost: dict[int, TaskFailure] | None = None,
    time_per_job: float | None = None,
) -> list[float]:
    """K_i of each run [m^3.5/kg^0.5]: as given, or solved from the leakage flow.

    Parameters
    ----------
    known : dict
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
    identities_of_runs, conditions = _conditions(runs)
    unsolved = [each for each in conditions.items() if each[0] not in known]
    size = max(1, min(_MOST_CONDITIONS, -(-len(unsolved) // max(1, engine.workers))))
    if len(unsolved) > WIDTH:
        size = -(-size // WIDTH) * WIDTH
    groups = [tuple(unsolved[first : first + size]) for first in range(0, len(unsolved), size)]
    reachable: dict[str, float] = {}
    failures: dict[str, TaskFailure] = {}

    def time_limit(group: _Group) -> float | None:
        return None if time_per_job is None else MOST_TRIALS * time_per_job * len(group)

    for result in run_halving(engine, _solve, groups, _halves, time_limit):
        if result.failure is None:
            for (identity, _), solution in zip(result.item, result.value, strict=True):
                known[identity], reachable[identity] = solution.coefficient, solution.reachable_flow
        elif isinstance(result.failure.error, HydrofdiError):
            raise result.failure.error
        elif lost is None:
            raise RuntimeError(f"a calibration failed: {result.failure.message}") from result.failure.error
        else:
            failures |= {identity: result.failure for identity, _ in result.item}
        on_solved(len(result.item))
    if lost is not None:
        lost |= {k: failures[each] for k, each in enumerate(identities_of_runs) if each in failures}
    coefficients = [
        known.get(identity, math.nan) if identity else run.parameters.leakage.internal_coefficient or 0.0
        for run, identity in zip(runs, identities_of_runs, strict=True)
    ]
    if required == "all" or (required == "any" and not any(value > 0.0 for value in coefficients)):
        solved = {identity: each for identity, each in conditions.items() if identity in known}
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


_Group = tuple[tuple[str, RunParameters], ...]
"""Identities of calibrations, and their conditions."""


def _solve(group: _Group) -> list[Calibration]:
    return solve_leakage_coefficients([condition for _, condition in group])


def _halves(group: _Group) -> list[_Group]:
    middle = len(group) // 2
    return [group[:middle], group[middle:]] if middle else []


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
        place = shown_values({name: condition.value(name) for name in varied})
        sentence = f"{unreachable_sentence(condition)}{' at ' if place else ''}{place}"
        if most is not None and most < (condition.leakage.internal_flow or 0.0):
            sentence += f"; the most that this actuator leaks is {convert(most, 'L/min'):.3g} L/min"
        elif most is not None:
            sentence += (
                ": the flow jumps across it as K_i grows; is the control loop unstable? Lower its gains"
            )
        sentences.append(sentence)
    distinct = list(dict.fromkeys(sentences))[:_SHOWN_MISTAKES]
    raise ConfigError([Issue(sentence, "leakage.internal_flow") for sentence in distinct])


def unreachable_sentence(condition: RunParameters) -> str:
    """What is wrong with a leakage flow that no K_i reaches."""
    return (
        f"no K_i gives a mean leakage of {convert(condition.leakage.internal_flow or 0.0, 'L/min'):.4g} L/min"
    )
