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
    run.save(folder / "run.h5")
    run.save(str(folder / "again.h5"))
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
    same = hydrofdi.load(folder / "study")
    page: str = same.report()
    figure: Figure = same.plot()
    figure.savefig(folder / "changes.png")
    assert d3.sizes["run"] == results.data.n_run
    assert page.startswith("#")
    results.dataset.close()


def train(folder: Path) -> None:
    noise = np.random.default_rng(1).standard_normal((100, 1000))
    detector: hydrofdi.Detector = hydrofdi.train(
        5e6 + 1e4 * noise,
        "dwt",
        output="d2",
        direction="both",
        false_alarm_rate="4 %",
        sampling_frequency="1 kHz",
    )
    detector.save(folder / "detector.json")
    low, high = detector.false_alarm_interval
    sentences: list[str] = detector.summary.splitlines()
    windows: hydrofdi.Table = hydrofdi.detect(
        folder / "detector.json", 5e6 + 1e4 * noise[0], sampling_frequency=1000
    )
    same = hydrofdi.Detector.load(str(folder / "detector.json")).judge(
        5e6 + 1e4 * noise[0], sampling_frequency=1000
    )
    frame: pandas.DataFrame = same.to_pandas()
    lines = [*detector.watch(hydrofdi.replay(5e6 + 1e4 * noise[0], sampling_frequency="1 kHz", rate="max"))]
    assert 0.0 <= low < detector.false_alarm_rate < high
    assert sentences[0].startswith("It judges")
    assert len(windows) == len(frame) == len(lines) == 1


def evaluate(folder: Path) -> None:
    records = [5e6 + scale * np.random.default_rng(1).standard_normal((40, 1000)) for scale in (1e4, 2e4)]
    label = ["sound"] * 40 + ["leaking"] * 40
    evaluation: hydrofdi.Evaluation = hydrofdi.evaluate(
        np.vstack(records),
        ["dwt"],
        label=label,
        healthy="sound",
        sampling_frequency=1e3,
        false_alarm_rate=0.2,
    )
    frame: pandas.DataFrame = evaluation.to_pandas()
    dataset: xarray.Dataset = evaluation.to_xarray()
    best: str = evaluation.best
    assert best.startswith("dwt.")
    assert set(frame.population) == {"healthy", "leaking"}
    assert dataset.q90_95.attrs["units"] == "m^3/s"


def inspect(folder: Path) -> None:
    samples = {"P1 [bar]": np.linspace(50.0, 51.0, 500), "time [s]": np.arange(500) / 1000.0}
    found: hydrofdi.Inspection = hydrofdi.inspect(samples)
    figure: Figure = found.plot()
    figure.savefig(folder / "look.png")
    counted: dict[str, int] = found.remarks
    listed: hydrofdi.Table = hydrofdi.indicators()
    assert found.n_record == 1
    assert isinstance(counted, dict)
    assert hydrofdi.indicators(listed["name"][0]).outputs
