"""First inspection of an FMU: its variables, and the plant block that they suggest."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydrofdi.config.plant import INPUTS, OUTPUTS
from hydrofdi.fmi import Model, Variable, read_model
from hydrofdi.settings.files import yaml_text
from hydrofdi.settings.messages import counted, number_text
from hydrofdi.tables.answer import Answer, Piece, Strong
from hydrofdi.tables.table import Table

_MOST_ROWS = 40
"""Variables of a kind that a table shows."""

_PRESSURE = (
    r"(?:^|[._])(?:p|press|pressure)_?(?:{0})$|(?:port|chamber|cham|vol|volume|side)_?(?:{0})(?![a-z0-9]).*p"
)
_USUAL = {
    "input_voltage": r"(?:^|[._])(?:u|volt|voltage|cmd|command|signal|valve)",
    "reference_position": r"ref|set_?point|demand",
    "load_force": r"load|force|(?:^|[._])f",
    "chamber_1_pressure": _PRESSURE.format("1|a|bore|cap|head"),
    "chamber_2_pressure": _PRESSURE.format("2|b|rod|ring|annulus"),
    "valve_supply_pressure": r"suppl|pump|(?:^|[._])p_?s$",
    "piston_position": r"(?:^|[._])(?:x|s|xp|x_p|pos|position|stroke|displacement)$",
    "piston_velocity": r"(?:^|[._])(?:v|vp|v_p|vel|velocity|speed)$",
    "spool_position": r"(?:spool|valve).*(?:x|s|pos|position)$|(?:^|[._])x_?v$",
    "oil_temperature": r"temp|(?:^|[._])t_?oil$",
    "internal_leakage_flow": r"leak",
}
"""Signal → how variables of it are usually called, in small letters."""

_LEAK = r"leak|seal|(?:^|[._])k_?il?$"
"""How parameters that set the internal leakage are usually called."""


@dataclass(frozen=True, repr=False)
class PlantInspection(Answer):
    """Contents of an FMU, as `hydrofdi.inspect` returns them; true if it can run here.

    Attributes
    ----------
    source : str
        Its path.
    fmi, tool : str
        Version of FMI, and the tool that made it.
    interfaces, platforms : list of str
        What it can be run as, and where.
    obstacle : str
        Why it cannot run here; empty if it can.
    variables : list of dict
        ``name``, ``causality``, ``variability``, ``type``, ``unit`` (empty if it states none), ``start``,
        ``min``, ``max`` [in that unit], and ``description`` of each variable.
    proposal : str
        An experiment file with the plant block that the names suggest; an ellipsis is to be completed.
    """

    source: str
    fmi: str
    tool: str
    interfaces: list[str]
    platforms: list[str]
    obstacle: str
    variables: list[dict[str, Any]]
    proposal: str

    def __bool__(self) -> bool:
        return not self.obstacle

    def parts(self) -> Iterator[Piece]:
        """What it is, its inputs, outputs and parameters, and the proposal."""
        yield Strong(self.source)
        yield {
            "FMI": f"{self.fmi}, {' and '.join(self.interfaces)}",
            "made by": self.tool,
            "platforms": ", ".join(self.platforms),
        }
        n_other = len(self.variables)
        for kind, title in (("input", "Inputs"), ("output", "Outputs"), ("parameter", "Parameters")):
            if found := [each for each in self.variables if each["causality"] == kind]:
                yield from ("", _table(title, found))
                n_other -= len(found)
        if n_other:
            yield f"{counted(n_other, 'other variable')}: --json lists all"
        yield from ("", Strong("Proposal, as a file with --write FILE"), self.proposal)

    def asides(self) -> Iterable[str]:
        """What speaks against running it."""
        return [f"it cannot run here: it {self.obstacle}"] if self.obstacle else []


def _table(title: str, variables: Sequence[dict[str, Any]]) -> Table:
    shown = variables[:_MOST_ROWS]
    more = len(variables) - len(shown)
    columns = {name: [each[name] for each in shown] for name in ("name", "unit", "start", "min", "max")}
    for name in ("start", "min", "max"):
        columns[name] = ["" if value is None else number_text(value) for value in columns[name]]
    columns["description"] = [each["description"] for each in shown]
    kept = {name: values for name, values in columns.items() if name == "name" or any(values)}
    return Table.of(kept, title=title, notes=(f"and {more:,} more: --json lists all",) if more else ())


def inspect_plant(path: Path) -> PlantInspection:
    """Read what an FMU says of itself, and propose which variables are the signals; nothing is executed."""
    model = read_model(path)
    interfaces = {"co-simulation": model.source.coSimulation, "model exchange": model.source.modelExchange}
    return PlantInspection(
        str(path),
        model.source.fmiVersion,
        model.source.generationTool or "not stated",
        [name for name, each in interfaces.items() if each is not None],
        model.platforms,
        model.obstacle,
        [
            {
                "name": each.name, "causality": each.causality, "variability": each.variability,
                "type": each.kind, "unit": each.unit, "start": each.start, "min": each.least,
                "max": each.most, "description": each.text,
            }
            for each in model.variables.values()
        ],
        _proposal(model, str(path)),
    )  # fmt: skip


def _proposal(model: Model, path: str) -> str:
    """An experiment on an FMU, with the variables whose names and units suggest what they are."""
    taken: set[str] = set()
    inputs = {name: text for name in INPUTS if (text := _found(model, name, taken))}
    free = [each for each in model.variables.values() if each.causality == "input" and not each.is_array]
    if "input_voltage" not in inputs and len(free) == 1 and not inputs:
        inputs["input_voltage"] = _written(free[0], "V")
    outputs = {name: text for name in OUTPUTS if (text := _found(model, name, taken))}
    plant: dict[str, Any] = {
        "fmu": path,
        "inputs": inputs or {"input_voltage": "…"},
        "outputs": {"chamber_1_pressure": "…"} | outputs,
    }
    settable = [
        each for each in model.variables.values() if each.causality == "parameter" and each.is_settable
    ]
    grid: dict[str, Any] = {}
    leaks = [each for each in settable if re.search(_LEAK, each.name.lower()) and each.value_type is float]
    if leaks and "internal_leakage_flow" in outputs:
        plant["leakage"] = {"coefficient": leaks[0].name}
        grid["leakage.internal_flow"] = [0, "0.1 L/min", "0.2 L/min"]
    moduli = [each for each in settable if re.search(r"beta|bulk|modulus", each.name.lower()) and each.start]
    for each in [each for each in moduli if each.si_unit == "Pa"][:1]:
        values = [float(f"{each.in_si(each.start) * factor:.4g}") for factor in (1.0, 1.5)]
        grid[f"plant.{each.name}"] = [f"{value / 1e6:g} MPa" for value in values]
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", model.path.stem).strip("-.") or "plant"
    default = getattr(model.source.defaultExperiment, "stepSize", None)
    step = 1e3 * float(default) if default and not model.takes_any_step else 0.1
    experiment: dict[str, Any] = {
        "name": name,
        "plant": plant,
        "record": {"duration": "20 s", "step": f"{step:g} ms"},
        "limits": {"time_per_job": "10 min"},
    }
    if grid:
        experiment["sweep"] = {"grid": grid}
    return yaml_text(experiment)


def _found(model: Model, signal: str, taken: set[str]) -> str:
    """The variable that is probably a signal; empty if none is."""
    is_input, needed = signal in INPUTS, {**INPUTS, **OUTPUTS}[signal]
    candidates = [
        each
        for each in model.variables.values()
        if (each.causality == "input") == is_input
        and each.causality not in ("parameter", "calculatedParameter", "independent", "structuralParameter")
        and each.si_unit in (needed, "1") and each.name not in taken and not each.is_array
        and each.value_type is float and re.search(_USUAL[signal], each.name.lower())
        and not each.name.startswith("der(")
    ]  # fmt: skip
    if not candidates:
        return ""
    # Outputs first, then what has the unit, then the shortest name.
    best = min(candidates, key=lambda each: (each.causality == "local", each.si_unit == "1", len(each.name)))
    taken.add(best.name)
    return _written(best, needed)


def _written(variable: Variable, needed: str) -> str:
    return variable.name if variable.si_unit == needed else f"{variable.name} […]"
