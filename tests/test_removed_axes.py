"""A file on top of another takes an axis of it away."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

BASE = (
    "name: base\nsweep: {grid: {fluid.bulk_modulus: [551 MPa, 1 GPa], leakage.internal_flow: [0, 1 L/min]}}\n"
)


def on_top(tmp_path, text):
    (tmp_path / "base.yaml").write_text(BASE)
    file = tmp_path / "mine.yaml"
    file.write_text(f"extends: base.yaml\nname: mine\n{text}\n")
    return file


def test_null_takes_an_inherited_axis_away(tmp_path):
    file = on_top(tmp_path, "sweep: {grid: {fluid.bulk_modulus: null}}")
    assert load_experiment(file).sweep.names == ["leakage.internal_flow"]


def test_null_for_an_axis_that_nothing_passes_on_is_a_mistake(tmp_path):
    file = on_top(tmp_path, "sweep: {grid: {supply.pressure: null}}")
    with pytest.raises(ConfigError, match=r"mine\.yaml:3: sweep\.grid\.supply\.pressure"):
        load_experiment(file)
