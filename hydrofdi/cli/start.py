"""``hydrofdi init``, ``configs``, ``check``, ``simulate``, ``indicators`` and ``schema``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import hydrofdi
from hydrofdi.cli.options import Config, Figure, Found, Settings
from hydrofdi.cli.terminal import draw, print_json, tell, write_out
from hydrofdi.errors import ConfigError

if TYPE_CHECKING:
    from hydrofdi.indicators.registry import Description


def init(
    name: Annotated[
        str, typer.Argument(help="Name of the experiment; writes NAME.yaml to this folder.")
    ] = "my-actuator",
    **data_sheet: Any,
) -> int:
    """Write a commented configuration for your own actuator.

    With --bore, --rod, --stroke, --supply, --valve and --mass: from its data sheet, with each derived number
    beside its formula. Else an example to fill in. It contains motion, load, sensors and study, with units,
    and runs unchanged. An existing file is never overwritten.
    """
    file = hydrofdi.init(name, **data_sheet)
    template = data_sheet.pop("template", "")
    if template == "description":
        write_out(f"{file}: the section 'actuator' of the description of your records\n")
        return 0
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
) -> Found:
    """List the ready configurations, or print one to copy.

    Their names work wherever a command takes a configuration: 'hydrofdi sweep table3'. A file of your own
    with the same name takes precedence.
    """
    from hydrofdi.settings.files import ready_copy, ready_hint, ready_names, ready_summary
    from hydrofdi.tables.answer import Reply

    asked = (name or "").removeprefix("configs/").removesuffix(".yaml").rstrip("/")
    table = hydrofdi.configs(asked)
    if len(table) and (asked not in ready_names() or str(name).endswith("/")):
        use = (
            "Use a name like a file: 'hydrofdi sweep table3', 'hydrofdi plan delays/smoke'.\n"
            "'hydrofdi configs NAME' prints one to copy."
        )
        return Reply({"configs": table}, [table, "", use])
    if asked not in ready_names():
        raise ConfigError(f"{name}: no such ready configuration{ready_hint(Path(asked))}")
    text = ready_copy(asked)
    return Reply({"name": asked, "about": ready_summary(asked), "text": text}, [text.removesuffix("\n")])


def check(config: Config = None, settings: Settings = None) -> Found:
    """Inspect an experiment before running it.

    Shows what is unusual about the machine and what to change; statics and speeds, hydraulic mode,
    step, leakage and stroke.

    Simulates up to 32 of the runs that differ in more than their sensors, spread evenly; step limits and what
    follows from parameters alone cover all runs. Exit code 1 if results would be wrong.
    """
    return hydrofdi.check(hydrofdi.load_experiment(config, settings or ()))


def simulate(config: Config = None, settings: Settings = None, figure: Figure = None, **more: Any) -> Found:
    """Simulate one actuator and print its features.

    If the file describes a sweep, only its nominal run is simulated.
    """
    from hydrofdi.config.values import shown_in

    experiment = hydrofdi.load_experiment(config, settings or ())
    with shown_in(experiment.units):
        run = hydrofdi.simulate(experiment, **more)
        if more:
            tell(f"stored {more['out']}")
        draw(run, figure)
    return run


def indicators(
    name: Annotated[str | None, typer.Argument(help="Indicator to describe, with its options.")] = None,
) -> Found:
    """List the indicators, or describe one."""
    from hydrofdi.api.records import indicators_table
    from hydrofdi.indicators.registry import describe, indicator_names
    from hydrofdi.records import Channel
    from hydrofdi.tables.answer import Reply
    from hydrofdi.tables.table import plain

    if name:
        described = describe(name)
        return Reply(plain(described), _described(described))
    found = [describe(each) for each in indicator_names()]
    used = sorted({channel for each in found for channel in each.channels})
    parts = (
        indicators_table(found),
        "\n" + ", ".join(f"{Channel(channel).symbol}: {channel}" for channel in used),
        "'hydrofdi indicators NAME' shows equation, source, options and outputs of one indicator.",
    )
    return Reply({"indicators": found}, parts)


def _described(indicator: Description) -> Iterator[Any]:
    from hydrofdi.settings.messages import typeset
    from hydrofdi.tables.answer import Strong
    from hydrofdi.tables.table import Table

    yield Strong(f"{indicator.name}, version {indicator.version}")
    yield indicator.summary
    yield {
        "equation": indicator.equation or "–",
        "caution": indicator.caution,
        "source": indicator.source,
        "channels": ", ".join(indicator.channels),
        "optional": ", ".join(indicator.optional_channels),
        "cost": indicator.cost,
        "scale": "needs channels in SI, not raw counts" if indicator.needs_scale else "",
    }
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
