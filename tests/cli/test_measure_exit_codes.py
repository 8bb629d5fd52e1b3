"""When ``measure`` ends with exit code 1."""

import numpy as np
import pytest

from tests.commands import run_json


def _write(file, one, two):
    np.savetxt(file, np.c_[one, two], delimiter=",", header="pressure_1 [bar],pressure_2 [bar]", comments="")
    return file


def _bad(kind, good):
    if kind == "stuck":
        return np.full_like(good, 80.0)
    if kind == "missing_values":
        return np.where(np.arange(len(good)) == 300, np.nan, good)
    return good


@pytest.mark.parametrize("kind", ["stuck", "missing_values", "short"])
def test_a_record_without_any_number_is_exit_code_1(tmp_path, kind):
    good = 80.0 + np.random.default_rng(1).normal(size=20 if kind == "short" else 1000)
    file = _write(tmp_path / "rig.csv", _bad(kind, good), good)
    options = ("--sampling-frequency", "500Hz", "--indicators", "dwt")
    (record,) = run_json("measure", file, *options, check=1)["records"]
    assert set(record["values"].values()) == {None}
    assert record["reasons"]


def test_a_bad_channel_takes_the_numbers_of_its_indicators_alone(tmp_path):
    good = 80.0 + np.random.default_rng(1).normal(size=1000)
    file = _write(tmp_path / "rig.csv", _bad("stuck", good), good)
    chosen = tmp_path / "chosen.yaml"
    chosen.write_text("indicators:\n  dwt: {}\n  rod: {kind: dwt, channel: chamber_2_pressure}\n")
    options = ("--sampling-frequency", "500Hz", "--indicators", chosen)
    (record,) = run_json("measure", file, *options, check=0)["records"]
    assert record["status"] == "stuck"
    assert record["values"]["dwt.d1"] is None
    assert record["values"]["rod.d1"] > 0.0
    assert set(record["reasons"]) == {"dwt"}
