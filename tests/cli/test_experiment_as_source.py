"""An experiment file as a source of records, and a single run as a file."""

import contextlib
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hydrofdi
from hydrofdi.api.sources import Described, open_records
from hydrofdi.errors import HydrofdiError
from hydrofdi.execution.simulated import SimulatedRecords
from tests.cli.test_measure import PRESSURES
from tests.commands import run, run_json
from tests.conftest import REPOSITORY


def test_whoever_simulates_an_experiment_file_says_how_many_records_and_finds_one_that_is_named(tmp_path):
    many = tmp_path / "many.yaml"
    many.write_text("record: {duration: 2 s}\nsweep: {grid: {supply.pressure: {linspace: [15e6, 17e6, 40]}}}")
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
    study.write_text(
        "record: {duration: 2 s}\nstudy:\n  population: {over: {friction.scale: {uniform: ±30 %}}}\n"
        "  healthy: {fit: 4, test: 4}\n  faults: {leakage.internal_flow: [0.5 L/min], each: 2, fit: 0}\n"
    )
    run("simulate", study, "--out", stored)
    run("export", stored, "--out", tmp_path / "run.csv", check=0)
    assert (tmp_path / "run.csv").read_text().startswith("time [s],P1 [Pa],P2 [Pa]")
    run("simulate", "--set", "store.signals=none", "--set", "record.duration=2 s", "--out", stored)
    assert "simulate again" in run("export", stored, "--out", tmp_path / "two.csv", check=2).stderr


FILES = [PRESSURES.read_bytes(), (REPOSITORY / "configs" / "table3.yaml").read_bytes()]
SUFFIXES = st.sampled_from([".csv", ".yaml", ".h5", ".txt", ".mat", ".npz", ".parquet", ".gz", ""])
PIECES = [*"a: \n{]1,;-\t", "&x", "p1 [bar]", "time [s]", "files", "name"]


@st.composite
def contents(draw):
    """Random bytes, words of tables and YAML, and files that are cut off or have wrong bytes in them."""
    whole = draw(st.sampled_from(FILES))
    damaged = bytearray(whole[: draw(st.integers(1, len(whole)))])
    for place in draw(st.lists(st.integers(0, len(damaged) - 1), max_size=20)):
        damaged[place] ^= draw(st.integers(1, 255))
    words = "".join(draw(st.lists(st.sampled_from(PIECES), max_size=60))).encode()
    return draw(st.sampled_from([bytes(damaged), words, FILES[0][:8] + words]) | st.binary(max_size=300))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("contents")


@settings(max_examples=150)
@given(content=contents(), suffix=SUFFIXES, frequency=st.sampled_from([None, 100.0]))
def test_no_content_is_a_fault(folder, content, suffix, frequency):
    path = folder / f"source{suffix}"
    path.write_bytes(content)
    with contextlib.suppress(HydrofdiError):
        source = open_records(path, said=Described(frequency))[0]
        if not isinstance(source, SimulatedRecords):
            hydrofdi.inspect(path, sampling_frequency=frequency)
