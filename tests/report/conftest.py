"""Experiments to report on: the study of the paper, and one with numbers chosen by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.experiment_file import requested_columns
from hydrofdi.store.results import read_results
from hydrofdi.store.shards import FileSignals

MADE_UP = """\
name: made_up
paper: maddahi2015
claims: [C1, C3]
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min, 2 L/min]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
"""

KILOPASCALS = [
    [5.0, 200.0, 300.0, 60.0, 150.0],
    [8.0, 240.0, 200.0, 66.0, 151.0],
    [4.9, 180.0, 290.0, 60.5, 150.0],
    [7.5, 230.0, 190.0, 65.0, 151.5],
    [4.8, 130.0, 210.0, 64.0, 150.5],
    [np.nan] * 5,
]
"""RMS of the details of each run; the last one failed."""

APPROXIMATIONS = np.outer(
    [9600.0, 9700.0, 9500.0, 9550.0, 9300.0, np.nan], [1.5, 2.0, 2.75, 4.0, 5.5]
).tolist()
"""RMS of the approximations of each run [kPa]."""


@pytest.fixture
def made_up(tmp_path: Path) -> ExperimentData:
    """Six runs with hand-made numbers, the last of which failed, and no signals."""
    config = tmp_path / "made_up.yaml"
    config.write_text(MADE_UP, encoding="utf-8")
    experiment = load_experiment(config)
    details, approximations = 1e3 * np.array(KILOPASCALS), 1e3 * np.array(APPROXIMATIONS)
    same = {
        "settled_from": 2.0, names.EXTERNAL_LEAKAGE_FLOWS[0]: 0.0, names.EXTERNAL_LEAKAGE_FLOWS[1]: 0.0,
        "clipped_share": 0.0, "unusual_share": 0.0, "pressure_variation": 0.8,
        names.LARGEST_CHAMBER_1_PRESSURE: 16.5e6, names.MEAN_CHAMBER_1_PRESSURE: 8.6e6,
    }  # fmt: skip
    columns = {each.name: values for each, values in requested_columns(expand_runs(experiment)).items()}
    columns |= {name: np.array([value] * 5 + [np.nan]) for name, value in same.items()}
    columns |= {
        names.RUN_ID: np.array([f"{position:016x}" for position in range(6)]),
        names.STATUS: np.array(["ok"] * 5 + ["diverged"]),
        names.MESSAGE: np.array([""] * 5 + ["the state grew without bound by t = 1 s"]),
        names.VERDICT: np.array(["ok", "unsettled", "ok", "cavitating, above_supply", "ok", "diverged"]),
        "cavitating_share": np.array([0.0, 0.0, 0.0, 0.002, 0.0, np.nan]),
        "above_supply_share": np.array([0.0, 0.0, 0.0, 0.15, 0.0, np.nan]),
        "settling_change": np.array([1e-7, 0.034, 1e-7, np.nan, 1e-7, np.nan]),
        names.DETAIL_RMS: details,
        names.APPROXIMATION_RMS: approximations,
        names.SETTLED_DETAIL_RMS: details * [0.9, 1.0, 1.1, 1.0, 1.0],
        names.SETTLED_APPROXIMATION_RMS: approximations,
        names.MEAN_LEAKAGE_FLOW: np.array([0.0, 0.0, 2e-6, 2.1e-6, 1e-3 / 30, np.nan]),
        names.LEAKAGE_COEFFICIENT: np.array([0.0, 0.0, 8e-10, 8e-10, 1.5e-8, 1.5e-8]),
        names.MODE_FREQUENCY: np.array([59.6, 66.1] * 2 + [59.6, np.nan]),
        names.MODE_DAMPING_RATIO: np.array([0.02, 0.021, 0.022, 0.023, 0.037, np.nan]),
    }
    path = Path("results/made_up/made_up.h5")
    return ExperimentData(path, experiment, columns, {"hydrofdi": "0.0", "numpy": "2.0"}, FileSignals(path))


@pytest.fixture(scope="session")
def paper(table3) -> ExperimentData:
    """The study of the paper as it came out."""
    return read_results(table3.directory)


@pytest.fixture(scope="session")
def paper_analysis(paper):
    return StudyReport(paper)


@pytest.fixture
def break_cell():
    """Changes the RMS of one cell of an experiment."""

    def changed(data: ExperimentData, position: int, level: int | slice, rms: float) -> ExperimentData:
        values = data.columns[names.DETAIL_RMS].copy()
        values[position, level] = rms
        return replace(data, columns=data.columns | {names.DETAIL_RMS: values})

    return changed
