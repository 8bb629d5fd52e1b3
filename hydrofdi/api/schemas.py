"""The JSON Schemas of the files that people write."""

from __future__ import annotations

import json
from typing import Any, Literal

from hydrofdi.api.arguments import choice_of
from hydrofdi.settings.ready import ready_folder


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
    name = choice_of("kind", kind, ("experiment", "measured", "monitor", "detector"))
    file = ready_folder() / ("schema.json" if name == "experiment" else f"{name}-schema.json")
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found
