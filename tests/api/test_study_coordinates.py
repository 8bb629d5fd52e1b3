"""The runs of a study are told apart by their population."""

import numpy as np
import pytest

import hydrofdi

STUDY = {
    "name": "told",
    "record": {"duration": "2 s"},
    "study": {
        "population": {"over": {"fluid.bulk_modulus": {"uniform": "±5 %"}}},
        "healthy": {"fit": 3, "test": 2, "shift": 2},
        "faults": {"leakage.internal_flow": ["0.1 L/min", "0.5 L/min"], "each": 2, "fit": 1},
        "shifts": {"stiffer": {"fluid.bulk_modulus": "1 GPa"}},
    },
}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    folder = tmp_path_factory.mktemp("told") / "told"
    return hydrofdi.sweep(STUDY, out=folder, engine="in-process").dataset


def test_each_run_has_the_population_that_its_parameters_show(dataset):
    assert dataset.population.dims == ("run",)
    leaking = dataset.internal_leakage_level.values * 60e3
    for name, flow in (("0.1 L/min", 0.1), ("0.5 L/min", 0.5)):
        assert leaking[dataset.population == name] == pytest.approx([flow] * 3)
    is_stiff = np.isclose(dataset.bulk_modulus, 1e9)
    np.testing.assert_array_equal(dataset.population == "stiffer", is_stiff)
    kinds = {"healthy": 5, "fault": 6, "shift": 2}
    assert {kind: int((dataset.population_kind == kind).sum()) for kind in kinds} == kinds


def test_fit_records_are_told_from_test_records(dataset):
    counts = dataset.is_fit.groupby("population").sum()
    assert counts.to_series().to_dict() == {"healthy": 3, "0.1 L/min": 1, "0.5 L/min": 1, "stiffer": 0}


def test_a_sweep_without_a_study_has_no_populations(small_sweep):
    assert "population" not in hydrofdi.load(small_sweep.directory).dataset.coords
