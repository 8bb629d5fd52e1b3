"""Options that several commands share."""

from __future__ import annotations

from typing import Annotated

import typer

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Set a parameter, e.g. fluid.bulk_modulus='689 MPa'. Repeatable."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON on standard output, and nothing else there.")]
SamplingFrequency = Annotated[
    str | None,
    typer.Option(metavar="FREQUENCY", help="Of a data file without a time column, e.g. 1kHz."),
]


def frequency(text: str | None) -> float | None:
    """A sampling frequency in Hz.

    Raises
    ------
    ConfigError
        The text is no frequency above zero.
    """
    from hydrofdi.errors import ConfigError
    from hydrofdi.units import parse_quantity

    if text is None:
        return None
    try:
        value = parse_quantity(text, "Hz")
    except ValueError as error:
        raise ConfigError(f"--sampling-frequency: {error}") from None
    if not 0.0 < value < float("inf"):
        raise ConfigError(f"--sampling-frequency: must be above zero; found {text!r}")
    return value
