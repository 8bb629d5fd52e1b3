"""Names of parameters and axes: what a user may write, and the one full name that is stored."""

import pytest

from hydrofdi.config import RunParameters, expand_runs
from hydrofdi.config.loading import load_experiment
from hydrofdi.config.request import SYMBOLS, full_name, parameter_names

EBM = "fluid.bulk_modulus"


def test_a_symbol_stands_for_one_parameter_and_is_not_the_last_part_of_another():
    symbols = [symbol for own in SYMBOLS.values() for symbol in own]
    assert len(set(symbols)) == len(symbols)
    assert not {name.partition(".")[2] for name in parameter_names()}.intersection(symbols)
    assert set(map(full_name, parameter_names())) == set(parameter_names())
    assert set(RunParameters.model_fields) >= {name.partition(".")[0] for name in SYMBOLS}


@pytest.mark.parametrize("study", [
    {"EBM": "689 MPa", "P_s": "10 MPa", "baseline": {"beta": "1 GPa"}, "units": {"EBM": "bar"}},
    {"bulk_modulus": "689 MPa", "supply": {"P_s": 10e6}, "baseline": {EBM: 1e9}, "units": {EBM: "bar"}},
    {EBM: "689 MPa", "supply.P_s": 10e6, "baseline": {"fluid.EBM": 1e9}, "units": {"beta": "bar"}},
])  # fmt: skip
def test_a_symbol_a_last_part_and_a_full_name_are_the_same(study):
    stated = load_experiment({"fluid": {"bulk_modulus": 689e6}, "supply": {"pressure": 10e6}})
    for loaded in (load_experiment(study), load_experiment(None, study)):
        assert loaded.nominal_parameters == stated.nominal_parameters
        assert (loaded.baseline[EBM], loaded.units[EBM]) == (1e9, "bar")


def test_symbols_name_what_is_drawn_compared_and_faulty():
    over = {"EBM": {"uniform": [5e8, 9e8]}, "m": {"uniform": "±10 %"}}
    where = "EBM > '600 MPa' and fluid.EBM <= '890 MPa' and m > 0"
    loaded = load_experiment({"sweep": {"sample": {"count": 8, "over": over}, "where": where}})
    values = expand_runs(loaded).axes[EBM]
    assert 0 < len(values) < 8
    assert min(values) > 6e8
    study = {"faults": {"q_il": ["1 L/min"], "each": 2}, "shifts": {"stiff": {"EBM": "1 GPa"}}}
    loaded = load_experiment({"study": {"healthy": {"fit": 2, "test": 2}, **study}})
    assert loaded.study.faults.over == {"leakage.internal_flow": [pytest.approx(1 / 60e3)]}
    assert loaded.study.shifts == {"stiff": {EBM: 1e9}}
    options = {"grid": {"kind": "modwt", "levels": 3}}
    assert load_experiment({"indicators": options}).indicators["grid"]["levels"] == 3, "no parameter"


THREE = [5e8, 6e8, 7e8]


@pytest.mark.parametrize(("axis", "values"), [
    (["500 MPa", 6e8, "0.7 GPa"], THREE),
    ({"linspace": ["500 MPa", "700 MPa", 3]}, THREE),
    ({"from": 5e8, "to": 7e8, "num": 3}, THREE),
    ({"start": "500 MPa", "stop": "700 MPa", "step": "100 MPa"}, THREE),
    ({"from": "500 MPa", "to": "750 MPa", "step": "100 MPa"}, THREE),
    ({"arange": ["500 MPa", "700 MPa", "100 MPa"]}, THREE[:2]),
    ({"arange": [0.1, 0.4, 0.1]}, [0.1, 0.2, 0.3]),
    ("500 MPa:700MPa:3", THREE),
    ("500 MPa:700 MPa:100 MPa", THREE),
    ("100 MPa:10 GPa:3:log", [1e8, 1e9, 1e10]),
    ({"geomspace": [1e8, 1e10, 3]}, [1e8, 1e9, 1e10]),
    ({"logspace": ["100 MPa", 1e10, 3]}, [1e8, 1e9, 1e10]),
], ids=str)  # fmt: skip
def test_an_axis_may_be_written_in_each_usual_form(axis, values):
    loaded = load_experiment({"sweep": {"grid": {"EBM": axis}}})
    assert loaded.sweep.grid == {EBM: pytest.approx(values, rel=1e-12)}
    assert expand_runs(loaded).n_swept == len(values)
