"""What a run is: identities, and Table 3."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from hydrofdi.config import RunSpec
from hydrofdi.config.experiment import Analysis, IndicatorChoice
from hydrofdi.config.request import RECORD_SECTIONS, RunParameters, RunRequest, parameter_names
from hydrofdi.config.runs import record_identity, run_identity
from hydrofdi.transforms import WaveletConfig


def changed(name):
    """The nominal request with one parameter changed, without a look at whether it fits the others."""
    section, field = name.split(".")
    nominal = RunRequest()
    content = getattr(nominal, section)
    value = getattr(content, field)
    other = value + 1 if isinstance(value, float | int) and not isinstance(value, bool) else "other"
    fields = {name: getattr(content, name) for name in type(content).model_fields}
    return nominal.with_valid_sections({section: type(content).model_construct(**fields | {field: other})})


@pytest.mark.filterwarnings("ignore:Pydantic serializer warnings")
def test_a_parameter_of_the_plant_the_drive_or_a_sensor_makes_another_record():
    requests = [RunRequest(), *map(changed, parameter_names(RunParameters))]
    assert len({record_identity(RunSpec(request)) for request in requests}) == len(requests)


def test_an_analysis_and_its_indicators_make_another_run_of_the_same_record():
    analyses = ("analysis.discard", "wavelet.name", "wavelet.levels", "wavelet.phase")
    assert {*RECORD_SECTIONS, "analysis", "wavelet"} == set(RunRequest.model_fields)
    coarse = {"kind": "dwt", "levels": 3}
    choices = [{"dwt": {}, "modwt": {}}, {"modwt": {}}, {"dwt": {}, "coarse": coarse}]
    runs = [
        *(RunSpec(RunRequest(), None, IndicatorChoice(json.dumps(choice))) for choice in choices),
        *(RunSpec(changed(name)) for name in analyses),
    ]
    nominal = RunSpec(RunRequest())
    default = RunSpec(RunRequest(), None, IndicatorChoice(json.dumps({"dwt": {}})))
    assert run_identity(nominal) == run_identity(default) == record_identity(nominal) == "bc086d6de4d04ac6"
    assert {record_identity(run) for run in runs} == {record_identity(nominal)}
    assert len({run_identity(run) for run in [nominal, *runs]}) == len(runs) + 1


def test_an_analysis_is_named_by_record_indicator_version_options_and_window():
    base = Analysis()
    other_wavelet, later = Analysis(wavelet=WaveletConfig(levels=4)), Analysis(n_discarded=10)
    more = Analysis(choice=IndicatorChoice(json.dumps({"dwt": {}, "modwt": {}})))
    names = [each.identities("record")["dwt"] for each in (base, other_wavelet, later)]
    assert len({*names, base.identities("other")["dwt"]}) == 4
    assert more.identities("record")["dwt"] == names[0]


def test_table_3_keeps_its_numbers(table3):
    leakage, bulk_modulus, *details = np.loadtxt(
        Path(__file__).parent / "table3.csv", delimiter=",", skiprows=1, unpack=True
    )
    with h5py.File(table3.file) as file:
        np.testing.assert_array_equal(file["internal_leakage_level"], leakage)
        np.testing.assert_array_equal(file["bulk_modulus"], bulk_modulus)
        np.testing.assert_allclose(file["detail_rms"], np.transpose(details), rtol=1e-9)
        phases = file["phase_detail_rms"]
        for level in range(5):
            np.testing.assert_array_equal(file[f"dwt.d{level + 1}"], file["detail_rms"][:, level])
            np.testing.assert_array_equal(file[f"dwt.d{level + 1}_phases"], phases[..., level])
