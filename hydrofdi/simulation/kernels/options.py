"""Model options that are resolved at compile time, so that unused ones cost nothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hydrofdi.config import RunParameters
from hydrofdi.physics.friction import FRICTION_LAWS, PAPER_FRICTION, Choice, choice_of_law

Chosen = bool | None
"""True or None. The two have different types, so that each combination of options is compiled separately."""


class ModelOptions(NamedTuple):
    """Options of the model beyond that of the paper; the equations test ``is not None``."""

    laminar_leakage: Chosen = None
    blended_leakage: Chosen = None
    ramped_leakage: Chosen = None
    intermittent_leakage: Chosen = None
    bristles: Chosen = None
    free_air: Chosen = None
    clamped_cavitation: Chosen = None
    limited_spool: Chosen = None
    hysteresis: Chosen = None
    lapped_valve: Chosen = None
    shifted_null: Chosen = None
    end_stops: Chosen = None
    load_force: Chosen = None
    supply_droop: Chosen = None
    closed_loop: Chosen = None
    measured_feedback: Chosen = None
    friction_law: Choice = PAPER_FRICTION

    @property
    def samples_more(self) -> bool:
        """Whether a lane has more samples than the paper's model."""
        return any((self.supply_droop, self.bristles, self.closed_loop))

    @classmethod
    def of(cls, run: RunParameters) -> ModelOptions:
        """Options of a run."""
        leakage, valve = run.leakage, run.valve
        return cls(
            laminar_leakage=leakage.law == "laminar" or None,
            blended_leakage=leakage.law == "blended" or None,
            ramped_leakage=leakage.onset in {"step", "ramp"} or None,
            intermittent_leakage=leakage.onset == "intermittent" or None,
            bristles=FRICTION_LAWS[run.friction.law].has_bristles or None,
            free_air=run.fluid.law == "free_air" or None,
            clamped_cavitation=run.fluid.cavitation == "clamped" or None,
            limited_spool=valve.is_limited or None,
            hysteresis=valve.hysteresis > 0.0 or None,
            lapped_valve=valve.lap != 0.0 or valve.lap_leakage != 0.0 or run.has_unequal_edges or None,
            shifted_null=valve.is_shifted or None,
            end_stops=run.actuator.end_stops == "elastic" or None,
            load_force=run.load.is_present or None,
            supply_droop=run.supply.droop == "first_order" or None,
            closed_loop=run.control.is_closed or None,
            measured_feedback=run.control.is_measured or None,
            friction_law=choice_of_law(run.friction.law),
        )


def group_by_options(runs: Sequence[RunParameters]) -> list[tuple[ModelOptions, list[int]]]:
    """Distinct options, each with the positions of its runs."""
    groups: dict[ModelOptions, list[int]] = {}
    for position, run in enumerate(runs):
        groups.setdefault(ModelOptions.of(run), []).append(position)
    return list(groups.items())


def group_by_kernel(runs: Sequence[RunParameters]) -> dict[tuple[ModelOptions, int], list[int]]:
    """Groups of runs that one kernel call can advance: by options and, in closed loop, steps per control."""
    groups: dict[tuple[ModelOptions, int], list[int]] = {}
    for position, run in enumerate(runs):
        steps = round(run.control.sample_time / run.record.step) if run.control.is_closed else 1
        groups.setdefault((ModelOptions.of(run), steps), []).append(position)
    return groups
