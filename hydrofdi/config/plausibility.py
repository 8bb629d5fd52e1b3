"""Values far from those of usual actuators: most often a missing unit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.config.sections.csv_input import parse_rows
from hydrofdi.config.shown_values import shown_in, shown_value
from hydrofdi.config.sweeps.distributions import argument_values
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.settings.counting import counted
from hydrofdi.settings.quantities import SI
from hydrofdi.units import parse_quantity


def unusual_values(experiment: ExperimentConfig, *, with_sweep: bool = True) -> list[str]:
    """A sentence on each parameter of which some value is far from the usual ones.

    Parameters
    ----------
    experiment : ExperimentConfig
    with_sweep : bool
        Whether values of ``sweep`` and ``ensemble`` count; without them, the nominal run is looked at.
    """
    values: dict[str, dict[Any, None]] = {}
    for name, value in _stated_values(experiment, with_sweep):
        values.setdefault(name, {})[value] = None
    with shown_in(experiment.units):
        sentences = [
            sentence
            for name in values
            for sentence in _sentences(name, values[name], experiment.units.get(name))
        ]
    sentences += _friction_sentences(*(max(values[f"friction.{part}"]) for part in ("breakaway", "coulomb")))
    longest = max(value for value in values["record.duration"] if isinstance(value, float))
    for file in values["input.file"]:
        sentences += _file_sentences(file, longest) if isinstance(file, str) else ()
    return sentences


def _stated_values(experiment: ExperimentConfig, with_sweep: bool) -> Iterator[tuple[str, Any]]:
    blocks = [experiment.ensemble, experiment.sweep] if with_sweep else []
    varied = {name for block in blocks for name in block.names}
    for name in parameter_names():
        if name not in varied:
            yield name, experiment.value(name)
    yield from experiment.baseline.items()
    for block in blocks:
        yield from block_values(block)


def block_values(block: SweepConfig) -> Iterator[tuple[str, Any]]:
    """The parameters that vary in a block, each with every value or end of its distribution."""
    for axes in (block.grid, block.zip):
        for name, values in axes.items():
            yield from ((name, value) for value in values)
    for name, distribution in (block.sample.over if block.sample else {}).items():
        yield from ((name, value) for value in argument_values(distribution))
    for part in block.union:
        yield from block_values(part)


def _sentences(name: str, stated: Iterable[Any], unit: str | None = None) -> Iterator[str]:
    """What is strange about the values of a parameter, some of which are written in a unit."""
    quantity = parameter_quantity(name)
    if quantity is None or quantity.usual is None:
        return
    low, high = (parse_quantity(bound, quantity.unit) for bound in quantity.usual)
    values = [value for value in stated if isinstance(value, float) and value != 0.0]
    below = sorted((value for value in values if abs(value) < low), key=abs)
    above = sorted((value for value in values if abs(value) > high), key=abs, reverse=True)
    for side, found in (("below", below), ("above", above)):
        if found:
            number = found[0] / parse_quantity(f"1 {unit}", quantity.unit) if unit else 0.0
            has_unit = _is_usual_number(number)
            may_group = has_unit and abs(number) >= 1.0 and low <= abs(found[0]) * 1000.0 <= high
            hint = "; is the point in it a thousands separator? Leave it out" if may_group else ""
            yield _sentence(name, quantity, side, found, has_unit=has_unit) + hint


def _is_usual_number(number: float) -> bool:
    """Whether people write a number of this size before a unit, so that it hardly is a number in SI."""
    return 0.01 <= abs(number) < 1e6


def _sentence(name: str, quantity: SI, side: str, found: list[float], *, has_unit: bool) -> str:
    others = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
    value, reason = f"{found[0]:g}", ""
    if has_unit:
        value = shown_value(name, found[0])
    elif quantity.unit != "1":
        value = f"{value} {quantity.unit.replace('*', '·')}"
        reason = "; a number without a unit is in SI"
    low, high = (bound.replace("*", "·") for bound in quantity.usual or ())
    place = side if found[0] > 0.0 else {"above": "beyond", "below": "short of"}[side]
    return f"{name} = {value}{others} is far {place} the usual {low} … {high}{reason}"


def _friction_sentences(breakaway: float, coulomb: float) -> Iterator[str]:
    """What is strange about the largest breakaway friction and the largest Coulomb friction [N]."""
    if breakaway < coulomb:
        less, more = shown_value("friction.breakaway", breakaway), shown_value("friction.coulomb", coulomb)
        yield (
            f"friction.breakaway = {less} is less than friction.coulomb = {more}:"
            " usually it is the larger of the two"
        )


def _file_sentences(text: str, duration: float) -> Iterator[str]:
    """What is strange about the rows of a file, for the longest record."""
    file, rows = text.partition("\n")[0].removeprefix("# "), parse_rows(text)
    n_late = int((rows.times > duration).sum())
    if n_late:
        yield (
            f"input.file = {file}: {n_late} of {counted(len(rows.times), 'row')} lie beyond"
            f" record.duration = {duration:g} s, the last at {rows.times[-1]:g} s"
        )
    amplitude = "input.amplitude" if rows.quantity == "voltage" else "control.amplitude"
    largest = float(abs(rows.values).max())
    for sentence in _sentences(amplitude, [largest]):
        yield f"input.file = {file}: the largest {rows.quantity}{sentence.removeprefix(amplitude)}"
