"""``hydrofdi init``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal

import typer

_NAME = re.compile(r"^name: .*$", re.MULTILINE)
_COMMANDS = re.compile(r"^#\n#   hydrofdi init .*\n", re.MULTILINE)


def init(
    name: Annotated[
        str, typer.Argument(help="Name of the experiment; writes NAME.yaml to this folder.")
    ] = "my-actuator",
    template: Annotated[
        Literal["actuator", "paper", "online"],
        typer.Option(
            "--from",
            help="actuator: the smallest leak that is found on your actuator. online: the delay until a "
            "new leak is found. paper: the actuator and the sweep of the paper.",
        ),
    ] = "actuator",
) -> int:
    """Write a commented configuration for your own actuator.

    It contains the data sheet, motion, load, sensors and study, with units, and runs unchanged. An existing
    file is never overwritten.
    """
    from hydrofdi.api.experiments import experiment_of
    from hydrofdi.cli.terminal import write_out
    from hydrofdi.settings.ready import ready_copy
    from hydrofdi.settings.yaml_source import scalar

    experiment = name.removesuffix(".yaml")
    experiment_of({"name": experiment}, {})
    stated = experiment if isinstance(scalar(experiment), str) else f"'{experiment}'"
    text = _NAME.sub(f"name: {stated}", ready_copy(f"templates/{template}"), count=1)
    file = Path(f"{experiment}.yaml")
    _write(file, _COMMANDS.sub("", text, count=1))
    write_out(
        f"{file}: enter your numbers, then run\n"
        f"  hydrofdi plan {file}\n"
        f"  hydrofdi sweep {file} && hydrofdi report results/{experiment}\n"
    )
    return 0


def _write(file: Path, text: str) -> None:
    from hydrofdi.errors import ConfigError

    try:
        with open(file, "x", encoding="utf-8") as new:
            new.write(text)
    except FileExistsError:
        raise ConfigError(f"{file}: already exists; choose another name") from None
    except OSError as error:
        raise ConfigError(f"{file}: cannot be written: {error.strerror}") from None
