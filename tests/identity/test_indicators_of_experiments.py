"""The ``indicators`` of an experiment."""

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch
from tests.conftest import sweep_in

SEVERAL = """\
name: several
record: {duration: 2 s}
indicators:
  dwt: {levels: 3}
  second: {kind: dwt, levels: 4, channel: chamber_2_pressure, phase: all}
sweep: {grid: {fluid.bulk_modulus: [551 MPa, 827 MPa]}}
"""


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("several"), SEVERAL)


def test_every_output_is_a_labelled_variable(several):
    with xarray.open_dataset(several.file, engine="h5netcdf") as runs:
        assert runs["second.d4"].dims == ("run",)
        assert runs["second.d2_phases"].dims == ("run", "second.phase")
        assert runs["second.d2_phases"].attrs["units"] == "Pa"
        assert "details of level 2" in runs["second.d2_phases"].attrs["long_name"]
        assert runs["second.analysis_id"].attrs["indicator"] == "dwt"
        assert runs["second.analysis_id"].attrs["version"] == 1
        assert '"levels":4' in runs["second.analysis_id"].attrs["options"]


def test_outputs_are_what_the_indicators_measure_of_the_stored_signals(several):
    with h5py.File(several.file) as file:
        channels = {
            channel: file[channel.value][:]
            for channel in (Channel("chamber_1_pressure"), Channel("chamber_2_pressure"))
        }
        batch = RecordBatch(channels, 500.0, tuple(file["run_id"].asstr()[:]))
        options = {
            "dwt": {"levels": 3},
            "second": {"kind": "dwt", "levels": 4, "channel": "chamber_2_pressure", "phase": "all"},
        }
        for name, values in measure(batch, make_indicators(options)).values.items():
            np.testing.assert_array_equal(file[name], values)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("indicators: [dvt]\n", r":1: indicators.dvt: there is no indicator 'dvt'; did you mean 'dwt'"),
        ("indicators:\n  dwt: {}\n  m: {kind: modwt, levls: 3}\n", r":3: indicators.m.levls: unknown key"),
        ("indicators:\n  dwt: {levels: 99}\n", r":2: wavelet.levels: must be at most 20"),
        ("wavelet: {levels: 3}\nindicators:\n  dwt: {levels: 4}\n", r":3: .*says 3; give it once"),
        ("indicators:\n  dwt: {channel: chamber_2_pressure}\n", r":2: indicators.dwt.channel: the label"),
    ],
)  # fmt: skip
def test_a_mistake_has_its_line(tmp_path, text, expected):
    file = tmp_path / "file.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=expected):
        load_experiment(file)


def test_the_options_of_dwt_are_those_of_the_wavelet(tmp_path):
    short, long = tmp_path / "short.yaml", tmp_path / "long.yaml"
    short.write_text("wavelet: {levels: 3, name: db4}\n")
    long.write_text("indicators: {dwt: {levels: 3, name: db4}}\n")
    assert load_experiment(short) == load_experiment(long)
