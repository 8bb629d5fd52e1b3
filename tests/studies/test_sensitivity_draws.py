"""Records of a study that show which nuisance moves a score."""

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.run_table.expansion import expand_runs
from hydrofdi.evaluation.populations import NOTHING, Kind

BULK, LAW, SUPPLY = NAMES = ("fluid.bulk_modulus", "friction.law", "supply.pressure")

STUDY = """
name: small
record: {duration: 2 s}
study:
  population:
    seed: 3
    over:
      fluid.bulk_modulus: {uniform: ±20 %}
      friction.law: {choice: [threshold, smooth]}
      supply.pressure: {uniform: ±5 %}
  healthy: {fit: 6, test: 5}
  faults: {leakage.internal_flow: [0.2 L/min], each: 4, fit: 2}
"""


def expanded(tmp_path, text=STUDY, sensitivity="{alone: 50}"):
    path = tmp_path / "study.yaml"
    path.write_text(text + (f"  sensitivity: {sensitivity}\n" if sensitivity else ""))
    return expand_runs(load_experiment(path))


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return expanded(tmp_path_factory.mktemp("study"))


def rows(table, kind, name):
    study = table.study
    (number,) = (
        place for place, each in enumerate(study.populations) if (each.kind, each.name) == (kind, name)
    )
    return np.flatnonzero(study.of_run == number)


def drawn(table, kind, name, parameter):
    return [table.runs.values(parameter)[row] for row in rows(table, kind, name)]


def test_alone_one_nuisance_varies_and_the_others_are_nominal(table):
    nominal = {BULK: 551e6, LAW: "threshold", SUPPLY: 17.2e6}
    for name in (*NAMES, NOTHING):
        for parameter in NAMES:
            values = set(drawn(table, Kind.ALONE, name, parameter))
            if parameter == name:
                assert len(values) == (2 if parameter == LAW else 50)
            else:
                assert values == {nominal[parameter]}


def test_every_record_has_noise_of_its_own_and_a_whole_seal(table):
    seeds = table.runs.values("measurement.seed")
    assert len(set(seeds)) == len(seeds)
    healthy = rows(table, Kind.ALONE, NOTHING)
    assert {table.runs[row].parameters.leakage.internal_coefficient for row in healthy.tolist()} == {0.0}


def test_a_design_takes_what_it_says(table, tmp_path):
    without = expanded(tmp_path, sensitivity="")
    assert len(table.runs) == len(without.runs) + (3 + 1) * 50
    ids = list(without.runs.record_digests())
    assert list(table.runs.record_digests())[: len(ids)] == ids
