"""Commented configurations of an own actuator, from a template or from its data sheet."""

from __future__ import annotations

import re
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from hydrofdi.config.data_sheet import name_text, section_text, sheet_text
from hydrofdi.config.loading import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.settings.arguments import path_of
from hydrofdi.settings.files import ready_copy, ready_names, ready_summary, write_new
from hydrofdi.settings.messages import brief, nearest
from hydrofdi.tables.table import Table

TEMPLATES = ("actuator", "paper", "online", "description")

_NAME = re.compile(r"^name: .*$", re.MULTILINE)

_COMMANDS = re.compile(r"^#\n#   hydrofdi init .*\n", re.MULTILINE)


def init(
    name: str = "my-actuator",
    *,
    template: Literal["actuator", "paper", "online", "description"] = "actuator",
    folder: str | PathLike[str] = ".",
    **data_sheet: Any,
) -> Path:
    """Write a commented configuration for your own actuator, as ``hydrofdi init`` does.

    Parameters
    ----------
    name : str
        Name of the experiment; the file is ``NAME.yaml``. An existing file is never overwritten.
    template : str
        Without a data sheet. actuator: the smallest leak that is found on your actuator. online: the delay
        until a new leak is found. paper: the actuator and the sweep of the paper. description: with a data
        sheet, the section ``actuator`` of a description of records.
    folder : path
        Where the file is written.
    **data_sheet
        Numbers of the data sheet, as fields of `CylinderSheet`: ``bore="50 mm"``, ``rod``, ``stroke``,
        ``supply``, ``valve="40 L/min at 70 bar"``, ``mass``; and, if known, ``null_leakage``, ``oil``,
        ``air``, ``temperature``, ``valve_frequency``, ``hose``, ``dead_volume``, ``measured_modulus``,
        ``return_pressure``, ``spring``, ``mounting``, ``double_rod``. Areas, volumes, valve,
        oil, motion, load, friction, controller, sensors and population follow, each beside its formula.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ConfigError
        With every mistake, or the file exists.

    Examples
    --------
    >>> import hydrofdi
    >>> sheet = dict(bore="50 mm", rod="28 mm", stroke="400 mm", supply="210 bar", mass="250 kg")
    >>> hydrofdi.init("press", valve="40 L/min at 70 bar", **sheet).name
    'press.yaml'
    """
    experiment = name.removesuffix(".yaml")
    load_experiment({"name": experiment}, {})
    if template not in TEMPLATES:
        raise ConfigError(f"template: {brief(template)} is unknown{nearest(str(template), TEMPLATES)}")
    if data_sheet or template == "description":
        text = sheet_text(experiment, data_sheet)
        if template == "description":
            text = section_text(text)
    else:
        copied = _NAME.sub(f"name: {name_text(experiment)}", ready_copy(f"templates/{template}"), count=1)
        text = _COMMANDS.sub("", copied, count=1)
    file = path_of(folder) / f"{experiment}.yaml"
    write_new(file, text)
    return file


def configs(group: str = "") -> Table:
    """The ready configurations, whose names work wherever a file does, as ``hydrofdi configs`` lists them.

    Parameters
    ----------
    group : str
        Those of a group alone, such as ``machines``.

    Examples
    --------
    >>> import hydrofdi
    >>> hydrofdi.configs("machines").columns
    ['name', 'about']
    """
    listed = [name for name in ready_names() if not group or name.startswith(f"{group}/")]
    return Table.of({"name": listed, "about": [*map(ready_summary, listed)]})
