"""The JSON Schemas of the files that people write."""

from __future__ import annotations

from typing import Any, Literal

from hydrofdi.api.arguments import choice_of


def schema(kind: Literal["experiment", "measured", "monitor", "detector"] = "experiment") -> dict[str, Any]:
    """The JSON Schema of a kind of file, as ``hydrofdi schema`` prints it.

    Raises
    ------
    ConfigError
        There is no such kind.

    Examples
    --------
    >>> import hydrofdi
    >>> hydrofdi.schema("measured")["$schema"]
    'https://json-schema.org/draft/2020-12/schema'
    """
    match choice_of("kind", kind, ("experiment", "measured", "monitor", "detector")):
        case "experiment":
            from hydrofdi.config.schema import experiment_schema

            return experiment_schema()
        case "measured":
            from hydrofdi.records.measured.description.schema import measured_schema

            return measured_schema()
        case "monitor":
            from hydrofdi.monitor.configuration import monitor_schema

            return monitor_schema()
        case _:
            from hydrofdi.detectors.trained.schema import detector_schema

            return detector_schema()
