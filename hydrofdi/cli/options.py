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
Json = Annotated[bool, typer.Option("--json", help="Print only JSON on standard output.")]
SamplingFrequency = Annotated[
    str | None,
    typer.Option(
        metavar="FREQUENCY", help="Sampling frequency of a data file without a time column, e.g. 1kHz."
    ),
]
