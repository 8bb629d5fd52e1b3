"""Uses of the public API as a person would write them; mypy checks their types, and a test runs them."""

from __future__ import annotations

from pathlib import Path

import xarray
from matplotlib.figure import Figure

import hydrofdi


def simulate(folder: Path) -> None:
    run: hydrofdi.Run = hydrofdi.simulate(bulk_modulus="689 MPa", internal_flow="0.2 L/min", duration="2 s")
    flow: float = run.features["mean_internal_leakage_flow"]
    signals: xarray.Dataset = run.to_xarray()
    figure: Figure = run.plot()
    figure.savefig(folder / "run.png")
    run.write(folder / "run.h5")
    run.write(str(folder / "again.h5"))
    assert flow > 0.0
    assert signals.chamber_1_pressure.attrs["units"] == "Pa"
