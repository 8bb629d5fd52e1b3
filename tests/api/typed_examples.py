"""Uses of the public API as a person would write them; mypy checks their types, and a test runs them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas
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


def measure(folder: Path) -> None:
    time = np.arange(2000) / 500.0
    pressure = 5e6 + 1e5 * np.sin(2.0 * np.pi * 40.0 * time)
    table: hydrofdi.Table = hydrofdi.measure(pressure, "dwt,ring_down", sampling_frequency="500 Hz")
    frame = pandas.DataFrame({"time [s]": time, "pressure 1 [bar]": pressure / 1e5})
    same = hydrofdi.measure(frame, ["dwt"])
    frame.to_csv(folder / "rig.csv", index=False)
    again = hydrofdi.measure(folder / "rig.csv")
    d2: float = table["dwt.d2"][0]
    dataset: xarray.Dataset = table.to_xarray()
    numbers: pandas.DataFrame = table.to_pandas()
    assert np.isclose(d2, [same["dwt.d2"][0], again["dwt.d2"][0], numbers["dwt.d2"][0]]).all()
    assert dataset["dwt.d2"].attrs["units"] == "Pa"


def sweep(folder: Path) -> None:
    stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"], "leakage.internal_flow": [0, "0.2 L/min"]}
    study = {"name": "stiffness", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    results: hydrofdi.Results = hydrofdi.sweep(study, out=folder / "study", engine="in-process")
    d3: xarray.DataArray = results.dataset.detail_rms.sel(level=3)
    same = hydrofdi.results(folder / "study")
    page: str = same.report()
    figure: Figure = same.plot()
    figure.savefig(folder / "changes.png")
    assert d3.sizes["run"] == results.data.n_run
    assert page.startswith("#")
    results.dataset.close()
