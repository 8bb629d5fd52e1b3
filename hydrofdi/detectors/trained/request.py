"""What a detector is asked to be: the forms in which its settings are given, and those of a fleet."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from hydrofdi.detectors.rules import Promise
from hydrofdi.detectors.trained import configuration
from hydrofdi.detectors.trained.file import DetectorFile, load_detector
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.rates import FEWEST_GROUPS
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.selection import Indicators


def options_of_machine(
    stated: configuration.DetectorConfig, made: Mapping[str, Indicator[Any]]
) -> configuration.DetectorConfig:
    """A detector whose options are those of indicators that were made for the machine of the records."""
    if stated.score is None:
        (options,) = (each.options.model_dump(exclude_unset=True) for each in made.values())
        return stated.model_copy(update={"options": options})
    return stated.model_copy(update={"indicators": stated.indicators | configuration.stated_indicators(made)})


def fleet_at(path: Path) -> DetectorFile:
    """The detector of a fleet, which has a summary of its machines."""
    file = load_detector(path)
    if file.fleet is None:
        raise ConfigError(
            f"{path}: is not a fleet: it needs {FEWEST_GROUPS} healthy machines or more, each a group or a"
            " record with two windows or more"
        )
    return file


def require_same_score(stated: configuration.DetectorConfig, fleet: configuration.DetectorConfig) -> None:
    """Check that settings beside a fleet only concern the false-alarm rate."""
    free = {*Promise.model_fields, "chart", "compensate", "accept"}
    for name in configuration.DetectorConfig.model_fields.keys() - free:
        if getattr(stated, name) != getattr(fleet, name):
            raise ConfigError(f"fleet: its file has {name}, so that the score is the same; leave it out")


def setting_keys() -> dict[str, tuple[str, ...]]:
    """Keyword of `train`, and option of the command → key of `DetectorConfig`."""
    keys: dict[str, tuple[str, ...]] = {
        name: ("window", name) for name in configuration.WindowConfig.model_fields if name != "channel"
    }
    keys["window"] = keys.pop("duration")
    keys |= {name: ("chart", name) for name in ("chart", "false_alarm_every")}
    return {name: (name,) for name in configuration.DetectorConfig.model_fields} | keys


def config_of(given: Indicators) -> str | PathLike[str] | Mapping[str, Any]:
    """The configuration of a detector; labels with options, and lists of names, are its ``indicators``."""
    if isinstance(given, str | PathLike):
        return given
    keys = {"indicators", "extends", *configuration.DetectorConfig.model_fields}
    if isinstance(given, Mapping) and not keys.isdisjoint(given):
        return given
    return {"indicators": given}
