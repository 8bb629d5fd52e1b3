"""An experiment file as a source of records, and a single run as a file."""

import contextlib
import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hydrofdi
from hydrofdi.api.sources import Described, open_records
from hydrofdi.errors import HydrofdiError
from hydrofdi.execution.simulated import SimulatedRecords
from tests.commands import run, run_json

MANY = """
name: many
record: {duration: 2 s}
sweep: {grid: {supply.pressure: {linspace: [15 MPa, 17 MPa, 40]}}}
"""
STUDY = """
name: press
record: {duration: 2 s}
study:
  population: {over: {friction.scale: {uniform: ±30 %}}}
  healthy: {fit: 4, test: 4}
  faults: {leakage.internal_flow: [0.5 L/min], each: 2, fit: 0}
"""


def test_whoever_simulates_an_experiment_file_says_how_many_records_and_finds_one_that_is_named(tmp_path):
    many = tmp_path / "many.yaml"
    many.write_text(MANY)
    measured = run("measure", many, "--json", check=0)
    assert measured.stderr.splitlines()[0] == f"{many}: simulating 40 records"
    names = [record["record_id"] for record in json.loads(measured.stdout)["records"]]
    assert len(names) == 40
    for command in (
        ("export", many, "--out", tmp_path / "signals"),
        ("replay", many, "--rate", "max", "--record", "1"),
    ):
        assert f"{many}: simulating 40 records" in run(*command, check=0).stderr
    found = [run_json("inspect", many, "--record", name)["records"] for name in names[1:4]]
    assert {*found} == {32, 33}


def test_the_single_run_of_a_study_keeps_its_signals(tmp_path):
    study, stored = tmp_path / "press.yaml", tmp_path / "run.h5"
    study.write_text(STUDY)
    run("simulate", study, "--out", stored)
    run("export", stored, "--out", tmp_path / "run.csv", check=0)
    assert (tmp_path / "run.csv").read_text().startswith("time [s],P1 [Pa],P2 [Pa]")
    run("simulate", "--set", "store.signals=none", "--set", "record.duration=2 s", "--out", stored)
    assert "simulate again" in run("export", stored, "--out", tmp_path / "two.csv", check=2).stderr


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
        assert hydrofdi.why(folder, run.run_id).run_id == run.run_id


MUSEUM = (Path(__file__).parents[1] / "museum" / "format_4_physics_3" / "pressures.h5").read_bytes()
EXPERIMENT = (Path(__file__).parents[2] / "configs" / "table3.yaml").read_bytes()
SUFFIXES = st.sampled_from([".csv", ".yaml", ".h5", ".txt", ".mat", ".npz", ".parquet", ".gz", ""])
WORDS = ["p1 [bar]", "time [s]", "files", "name"]
PIECES = ["a", ":", " ", "\n", "{", "]", "1", ",", ";", "-", "\t", "&x", *WORDS]


@st.composite
def contents(draw):
    """Random bytes, words of tables and YAML, and files that are cut off or have wrong bytes in them."""
    whole = draw(st.sampled_from([MUSEUM, EXPERIMENT]))
    cut = whole[: draw(st.integers(0, len(whole)))]
    flipped = bytearray(whole)
    for place in draw(st.lists(st.integers(0, len(whole) - 1), max_size=20)):
        flipped[place] ^= draw(st.integers(1, 255))
    words = "".join(draw(st.lists(st.sampled_from(PIECES), max_size=60))).encode()
    return draw(
        st.sampled_from([cut, bytes(flipped), words, draw(st.binary(max_size=300)), MUSEUM[:8] + words])
    )


@pytest.fixture(scope="module")
def folder_contents(tmp_path_factory):
    return tmp_path_factory.mktemp("contents")


@settings(max_examples=150)
@given(content=contents(), suffix=SUFFIXES, frequency=st.sampled_from([None, 100.0]))
def test_no_content_is_a_fault(folder_contents, content, suffix, frequency):
    path = folder_contents / f"source{suffix}"
    path.write_bytes(content)
    with contextlib.suppress(HydrofdiError):
        source = open_records(path, said=Described(frequency))[0]
        if not isinstance(source, SimulatedRecords):
            hydrofdi.inspect(path, sampling_frequency=frequency)
