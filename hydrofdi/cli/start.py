"""``hydrofdi init``, ``configs``, ``check``, ``simulate``, ``indicators`` and ``schema``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import hydrofdi
from hydrofdi.cli.options import Config, Figure, Json, Settings
from hydrofdi.cli.terminal import answer, draw, facts, print_json, tell, write_out
from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import counted
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.api.check import Check
    from hydrofdi.indicators.registry import Description


def init(
    name: Annotated[
        str, typer.Argument(help="Name of the experiment; writes NAME.yaml to this folder.")
    ] = "my-actuator",
    template: Annotated[
        Literal["actuator", "paper", "online"],
        typer.Option(
            "--from",
            help="Without a data sheet. actuator: the smallest leak that is found on your actuator. online:"
            " the delay until a new leak is found. paper: the actuator and the sweep of the paper.",
        ),
    ] = "actuator",
    **data_sheet: Any,
) -> int:
    """Write a commented configuration for your own actuator.

    With --bore, --rod, --stroke, --supply, --valve and --mass: from its data sheet, with each derived number
    beside its formula. Else an example to fill in. It contains motion, load, sensors and study, with units,
    and runs unchanged. An existing file is never overwritten.
    """
    file = hydrofdi.init(name, template=template, **data_sheet)
    look = f"check {file} && hydrofdi plan {file}" if data_sheet else f"plan {file}"
    write_out(
        f"{file}: {'look at the guesses' if data_sheet else 'enter your numbers'}, then run\n"
        f"  hydrofdi {look}\n"
        f"  hydrofdi sweep {file} && hydrofdi report results/{file.stem}\n"
    )
    return 0


def init_options() -> dict[str, Any]:
    """The options of `init` that follow from the model of a data sheet."""
    from hydrofdi.cli.options import options_of
    from hydrofdi.config.data_sheet import CylinderSheet

    return options_of(CylinderSheet, {name: (name,) for name in CylinderSheet.model_fields})


def configs(
    name: Annotated[str | None, typer.Argument(help="Configuration to print, or group to list.")] = None,
    json: Json = False,
) -> int:
    """List the ready configurations, or print one to copy.

    Their names work wherever a command takes a configuration: 'hydrofdi sweep table3'. A file of your own
    with the same name takes precedence.
    """
    from hydrofdi.settings.ready import ready_copy, ready_hint, ready_names, ready_summary

    asked = (name or "").removeprefix("configs/").removesuffix(".yaml").rstrip("/")
    table = hydrofdi.configs(asked)
    if len(table) and (asked not in ready_names() or str(name).endswith("/")):
        use = (
            "Use a name like a file: 'hydrofdi sweep table3', 'hydrofdi plan delays/smoke'.\n"
            "'hydrofdi configs NAME' prints one to copy."
        )
        answer({"configs": [*table]}, lambda _: (table, "", use), json=json)
        return 0
    if asked not in ready_names():
        raise ConfigError(f"{name}: no such ready configuration{ready_hint(Path(asked))}")
    text = ready_copy(asked)
    answer({"name": asked, "about": ready_summary(asked), "text": text}, text.removesuffix("\n"), json=json)
    return 0


def check(config: Config = None, settings: Settings = None, json: Json = False) -> int:
    """Inspect an experiment before running it.

    Shows what is unusual about the machine and what to change; statics and speeds, hydraulic mode and
    bands, step, record, leakage, stroke and sensor noise.

    Simulates up to 32 of the runs that differ in more than their sensors, spread evenly; step limits and what
    follows from parameters alone cover all runs. Exit code 1 if results would be wrong.
    """
    from hydrofdi.config.shown_values import shown_in

    experiment = hydrofdi.load_experiment(config, settings or ())
    found = hydrofdi.check(experiment)
    with shown_in(experiment.units):
        answer(found, _checked, json=json)
    return 0 if found else 1


def _checked(found: Check) -> Iterator[Any]:
    """Machine, modes, step, record, noise and warnings."""
    from rich.text import Text

    from hydrofdi.api.check import MOST_ROWS, machine_text, modes_table, noise_text
    from hydrofdi.api.plausible import plausibility_table

    yield from (plausibility_table(found.plausibility), "", Text("Machine, nominal", "bold"))
    yield from (machine_text(found), "")
    if len(found.modes) <= MOST_ROWS:
        yield from (modes_table(found), "")
    if found.n_left_out or len(found.modes) > MOST_ROWS:
        n_distinct = len(found.modes) + found.n_left_out
        kinds = f"{n_distinct:,} that differ in more than sensors, of " if n_distinct < found.n_run else ""
        yield f"{len(found.modes)} of {kinds}{counted(found.n_run, 'run')} are simulated; --json lists each"
    yield (
        f"step {convert(found.step, 'ms'):g} ms: stable up to"
        f" {convert(found.step_limits[found.binding], 'ms'):.3g} ms, limited by {found.binding}"
    )
    shares = (f"d{level} {100.0 * share:.1f}" for level, share in enumerate(found.boundary_shares, 1))
    periods = f", {counted(found.n_period, 'period')}" if math.isfinite(found.n_period) else ""
    yield f"{counted(found.n_sample, 'sample')}{periods}; coefficients at ends [%]: {', '.join(shares)}"
    if found.noise:
        yield f"P_1 noise over the weakest run [%]: {noise_text(found)}"
    yield ""
    yield from (Text(f"problem: {problem}", "bold red") for problem in found.problems)
    yield from (Text(f"warning: {warning}") for warning in found.warnings)
    if found and not found.warnings:
        yield "no warnings"


def simulate(
    config: Config = None, settings: Settings = None, figure: Figure = None, json: Json = False, **more: Any
) -> int:
    """Simulate one actuator and print its features.

    If the file describes a sweep, only its nominal run is simulated.
    """
    from hydrofdi.config.shown_values import shown_in
    from hydrofdi.quality.doubts import REMEDIES, doubts_of

    experiment = hydrofdi.load_experiment(config, settings or ())
    with shown_in(experiment.units):
        run = hydrofdi.simulate(experiment, **more)
        if more:
            tell(f"stored {more['out']}")
        draw(run, figure)
        for warning in run.warnings:
            tell(f"warning: {warning}")
        answer(run, lambda run: [run.table], json=json)
        if run.status != "ok":
            tell(f"the run failed: {run.status}: {run.message}; {REMEDIES[run.status]}")
            return 1
        for doubt in doubts_of(run.verdict):
            tell(f"{doubt.word}: {doubt.remedy}")
        return 0


_WIDE = 110
"""Width from which the terminal has room for the sources [columns]."""


def indicators(
    name: Annotated[str | None, typer.Argument(help="Indicator to describe, with its options.")] = None,
    json: Json = False,
) -> int:
    """List the indicators, or describe one."""
    from dataclasses import asdict

    from hydrofdi.api.measuring import described_indicators
    from hydrofdi.indicators.registry import describe

    if name:
        described = describe(name)
        answer(asdict(described), lambda _: _described(described), json=json)
        return 0
    all_that_load, doubts = described_indicators()
    tell(*(f"warning: {doubt}" for doubt in doubts))
    record = {"indicators": [asdict(each) for each in all_that_load]}
    answer(record, lambda _: _listed(all_that_load), json=json)
    return 0


def _listed(indicators: list[Description]) -> Iterator[Any]:
    from hydrofdi.api.measuring import indicators_table
    from hydrofdi.cli.tables import terminal
    from hydrofdi.records import Channel

    yield indicators_table(indicators, with_sources=terminal().width >= _WIDE)
    used = sorted({channel for each in indicators for channel in each.channels})
    yield "\n" + ", ".join(f"{Channel(channel).symbol}: {channel}" for channel in used)
    yield "'hydrofdi indicators NAME' shows equation, source, options and outputs of one indicator."


def _described(indicator: Description) -> Iterator[Any]:
    from rich.text import Text

    from hydrofdi.report.table import Table
    from hydrofdi.settings.readable import typeset

    yield Text(f"{indicator.name}, version {indicator.version}", "bold")
    yield indicator.summary
    yield from facts({
        "equation": indicator.equation or "–",
        "caution": indicator.caution,
        "source": indicator.source,
        "channels": ", ".join(indicator.channels),
        "optional": ", ".join(indicator.optional_channels),
        "cost": indicator.cost,
        "scale": "needs channels in SI, not raw counts" if indicator.needs_scale else "",
    })  # fmt: skip
    options, outputs = indicator.options, indicator.outputs
    dims = ("".join(f" × {n} {name}" for name, n in output.dims.items()) for output in outputs)
    of_options = {
        "option": [option.name for option in options],
        "default": [option.default for option in options],
        "meaning": [option.text.replace("``", "") for option in options],
    }
    of_outputs = {
        "output": [output.name for output in outputs],
        "unit": [typeset(output.unit) for output in outputs],
        "under leakage": [output.departure for output in outputs],
        "meaning": [output.long_name + more for output, more in zip(outputs, dims, strict=True)],
    }
    yield from ("", Table.of(of_options, title="Options"), "", Table.of(of_outputs, title="Outputs"))


def schema(
    kind: Annotated[
        Literal["experiment", "measured", "monitor", "fleet", "detector"],
        typer.Argument(help="Kind of file that the schema describes."),
    ] = "experiment",
) -> int:
    """Print the JSON Schema of a kind of file.

    For editors and programs: experiment files, descriptions of measured files, configurations and fleets of
    'hydrofdi monitor', and the detector files that 'hydrofdi train' writes.
    """
    print_json(hydrofdi.schema(kind))
    return 0
