"""Verdicts on the records of a study are on its first page and in `status`."""

from __future__ import annotations

import pytest

from tests.commands import run_hydrofdi

STUDY = """
name: short
record: {duration: 2 s, sampling_frequency: 500 Hz}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 5, test: 4, shift: 2}
  shifts: {narrow: {pressure_1_sensor.highest: 1 MPa}}
  faults: {leakage.internal_flow: [1 L/min], each: 3, fit: 0}
detection: {indicators: [dwt]}
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("verdicts")
    (folder / "short.yaml").write_text(STUDY)
    out = folder / "out"
    done = run_hydrofdi("sweep", folder / "short.yaml", "--out", out, "--engine", "in-process")
    assert "2 clipped: widen pressure_1_sensor.lowest" in done.stderr
    return out


def test_the_first_page_counts_the_verdicts_of_each_population(swept):
    text = " ".join(run_hydrofdi("report", swept, "--full").stdout.split())
    assert "2 of 14 records are clipped (2 of 2 'narrow')" in text
    assert "Remedy: widen pressure_1_sensor.lowest" in text


def test_the_status_counts_the_verdicts_with_the_remedy(swept):
    lines = run_hydrofdi("status", swept).stdout.splitlines()
    assert lines[0] == "14 planned, 14 done, 0 failed, 0 missing (14 ok)"
    assert any(line.startswith("2 clipped: widen pressure_1_sensor.lowest") for line in lines[1:])
