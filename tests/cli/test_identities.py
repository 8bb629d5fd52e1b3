"""Identities that one command prints are accepted by the others."""

import pytest

import hydrofdi


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("identities") / "out"
    grid = {"leakage.internal_coefficient": [0.0, 2e-9]}
    study = {"name": "asked", "record": {"duration": "2 s"}, "sweep": {"grid": grid}}
    hydrofdi.sweep(study, out=out, engine="in-process")
    return out


def test_the_identity_that_measure_prints_leads_to_its_run(folder, tmp_path):
    runs = hydrofdi.load(folder).data.columns["run_id"]
    for record_id in hydrofdi.measure(folder)["record_id"].tolist():
        run = hydrofdi.why(folder, record_id[:8])
        assert run.record_id == record_id
        assert run.run_id in runs
        (file,) = hydrofdi.export(folder, tmp_path / record_id, runs=[record_id[:8]]).files
        assert run.run_id[:12] in file.name


def test_the_identity_of_a_run_still_leads_to_it(folder):
    for run_id in hydrofdi.load(folder).data.columns["run_id"]:
        assert hydrofdi.why(folder, str(run_id)).run_id == run_id
