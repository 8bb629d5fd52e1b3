"""``hydrofdi check`` sums up many runs instead of listing them."""

from __future__ import annotations

import json

import pytest

from hydrofdi.api.selection import select_runs
from hydrofdi.config import load_experiment
from tests.commands import run_hydrofdi

SHORT = "record: {duration: 2 s}\ninput: {period: 1 s}\n"
SAMPLE = SHORT + (
    "sweep: {sample: {count: 40, over: {fluid.bulk_modulus: {uniform: [540 MPa, 690 MPa]},"
    " friction.viscous: {uniform: [40, 60]}}}}\n"
)
STUDY = (
    SHORT
    + """\
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±10 %}}}
  healthy: {fit: 60, test: 20}
  faults: {leakage.internal_flow: [0.1 L/min, 1 L/min], each: 10}
  shifts: {stiffer: {fluid.bulk_modulus: 827 MPa}}
"""
)


@pytest.mark.parametrize("text", [SAMPLE, STUDY], ids=["sample", "study"])
def test_many_runs_are_summed_up_in_one_sentence_and_one_table(tmp_path, text):
    file = tmp_path / "drawn.yaml"
    file.write_text(text)
    record = json.loads(run_hydrofdi("check", file, "--json").stdout)
    assert len(record["modes"]) > 40
    assert sum("edge of a wavelet band" in warning for warning in record["warnings"]) == 1
    printed = run_hydrofdi("check", file).stdout
    assert len(printed.splitlines()) < 30
    moduli = [mode["bulk_modulus"] / 1e6 for mode in record["modes"]]
    least, largest = (
        float(line.split()[1])
        for line in printed.splitlines()
        if line.split()[:1] in (["least"], ["largest"])
    )
    assert (least, largest) == pytest.approx((min(moduli), max(moduli)), rel=1e-5)


def test_some_records_of_every_population_of_a_study_are_looked_at(tmp_path):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY)
    jobs = select_runs(load_experiment(file), most=15).jobs
    flows = {job.parameters.leakage.internal_flow or 0.0 for job in jobs}
    assert sorted(flows) == pytest.approx([0.0, 0.1e-3 / 60, 1e-3 / 60])
    assert 827e6 in {job.parameters.fluid.bulk_modulus for job in jobs}
