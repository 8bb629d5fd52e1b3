"""``hydrofdi schema``."""

from __future__ import annotations


def schema() -> int:
    """Print the JSON Schema of experiment files, for editors."""
    from hydrofdi.cli.rendering import print_json
    from hydrofdi.config.schema import experiment_schema

    print_json(experiment_schema())
    return 0
