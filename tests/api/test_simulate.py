"""`hydrofdi.simulate`: keywords, errors, and what a run gives."""

import subprocess
import sys

import numpy as np
import pytest

import hydrofdi
from hydrofdi.store.reading import read_experiment
from tests.commands import run_json

SHORT = {"duration": "2 s"}


@pytest.fixture(scope="module")
def leaking():
    return hydrofdi.simulate(bulk_modulus="689 MPa", internal_flow="0.2 L/min", **SHORT)


def test_keywords_and_settings_are_found_in_their_sections():
    given = {"bulk_modulus": 1e9, "pressure_1_sensor__noise": 2.0, "friction.scale": 3.0, "name": "x"}
    keywords = hydrofdi.load_experiment(None, given)
    dotted = {"fluid.bulk_modulus": 1e9, "pressure_1_sensor.noise": 2.0, "friction.scale": 3.0, "name": "x"}
    assert keywords == hydrofdi.load_experiment(None, dotted)
    assert keywords == hydrofdi.load_experiment(None, [f"{key}={value}" for key, value in given.items()])


def test_files_mappings_and_keywords_ask_for_the_same_run(tmp_path, leaking):
    file = tmp_path / "mine.yaml"
    file.write_text("fluid: {bulk_modulus: 689 MPa}\nrecord: {duration: 2 s}\n")
    section = {"fluid": {"bulk_modulus": "689 MPa"}, "record": {"duration": np.float64(2.0)}}
    same = [
        hydrofdi.simulate(file, internal_flow="0.2 L/min"),
        hydrofdi.simulate(str(file), leakage__internal_flow=0.2e-3 / 60.0),
        hydrofdi.simulate(section, **{"leakage.internal_flow": "0.2 L/min"}),
        hydrofdi.simulate(fluid={"bulk_modulus": "689 MPa"}, internal_flow="0.2 L/min", **SHORT),
        hydrofdi.simulate(hydrofdi.load_experiment(file, {"leakage.internal_flow": "0.2 L/min"})),
    ]
    assert {each.run_id for each in same} == {leaking.run_id}
    assert section["record"] == {"duration": 2.0}


def test_a_run_says_what_the_command_says(leaking):
    settings = ["fluid.bulk_modulus=689 MPa", "leakage.internal_flow=0.2 L/min", "record.duration=2 s"]
    printed = run_json("simulate", *(word for each in settings for word in ("--set", each)))
    assert leaking.to_dict() == printed
    assert leaking.features["dwt.d2"] == printed["detail_rms_Pa"][1]
    assert (leaking.status, leaking.message) == ("ok", "")


def test_a_run_is_a_dataset_with_units(leaking):
    data = leaking.to_xarray()
    assert data.chamber_1_pressure.dims == ("time",)
    assert data.detail_rms.dims == ("level",)
    assert data.level.values.tolist() == [1, 2, 3, 4, 5]
    assert (data.time.attrs["units"], data.internal_leakage_flow.attrs["units"]) == ("s", "m3 s-1")
    assert all({"units", "long_name"} <= each.attrs.keys() for each in data.data_vars.values())
    flow = np.abs(data.internal_leakage_flow).mean().item()
    np.testing.assert_allclose(flow, data.mean_internal_leakage_flow, rtol=0.2)
    assert data.attrs["run_id"] == leaking.run_id


def test_a_data_frame_of_a_run_is_measured_like_the_run(leaking):
    frame = leaking.to_pandas()
    assert frame.columns[0] == "time [s]"
    same, own = hydrofdi.measure(frame, "dwt"), hydrofdi.measure(leaking, "dwt")
    np.testing.assert_allclose(same["dwt.d2"], own["dwt.d2"], rtol=1e-12)


def test_outputs_with_dimensions_keep_them():
    run = hydrofdi.simulate(indicators=["dwt", "volterra"], **SHORT)
    coefficients = run.to_xarray()["volterra.coefficients"]
    assert coefficients.dims == ("volterra.term",)
    assert "volterra.coefficients" not in run.features


def test_notebooks_show_runs_and_figures(leaking):
    page = leaking._repr_html_()
    assert "RMS of d2" in page
    assert page.count("<tr>") == len(leaking.table) + 1
    assert leaking.plot()._repr_png_().startswith(b"\x89PNG")
    assert "RMS of d2" in repr(leaking)


def test_strange_settings_are_told_with_the_run():
    run = hydrofdi.simulate(mass="1 g", **SHORT)
    assert any("actuator.mass" in warning for warning in run.warnings)
    assert "actuator.mass" in run._repr_html_()


def test_a_run_that_fails_says_how():
    run = hydrofdi.simulate(bulk_modulus="1e7 MPa", **SHORT)
    assert run.status != "ok"
    assert run.message
    assert run.status in run._repr_html_()


def test_a_written_run_is_read_again_and_nothing_else_is_overwritten(tmp_path, leaking):
    leaking.save(tmp_path / "run.h5")
    assert read_experiment(tmp_path / "run.h5").columns["run_id"][0] == leaking.run_id
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(hydrofdi.HydrofdiError):
        leaking.save(str(tmp_path / "notes.txt"))


def test_without_the_extra_one_sentence_says_what_to_install():
    code = (
        "import sys; sys.modules['xarray'] = None; import hydrofdi\n"
        "try: hydrofdi.simulate(duration='2 s').to_xarray()\n"
        "except hydrofdi.HydrofdiError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "xarray is not installed: pip install 'hydrofdi[notebook]'"
