"""The first page of a report on the terminal, --full, and narrow terminals."""

import json
import re

import pytest

from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

OWN = """\
name: own
record: {duration: 1 s}
store: {signals: none}
indicators: [dwt, modwt]
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.1 L/min, 0.5 L/min, 1 L/min]
    supply.pressure: [12 MPa, 15 MPa, 18 MPa]
"""
SAMPLED = """\
name: sampled
record: {duration: 1 s}
store: {signals: none}
sweep: {sample: {count: 128, over: {fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}}}
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("own"), OWN)


@pytest.fixture(scope="module")
def sampled(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("sampled"), SAMPLED)


def printed(sweep, *arguments, **options):
    done = run_hydrofdi("report", sweep.directory, *arguments, cwd=sweep.folder, **options)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_first_page_says_what_was_varied_and_how_features_respond(own):
    page = printed(own)
    assert len(page.splitlines()) < 70
    assert "supply.pressure [MPa]" in page
    assert "12 … 18" in page
    assert re.search(r"\d+ more tables: --full shows them", page)


def test_a_sampled_sweep_shows_quantiles_and_programs_get_every_run(sampled):
    assert len(printed(sampled).splitlines()) < 40
    text = printed(sampled, "--full")
    assert "95 %" in text
    assert "ank correlation" in text
    assert len(json.loads(printed(sampled, "--json"))["rows"]) == 256
    assert len(printed(sampled, "--format", "csv").splitlines()) == 1 + 5 * 256
    assert len(re.findall(r"^ +sealed ", printed(sampled, "--full"), re.M)) >= 256


def test_no_number_is_cut_at_60_columns(own):
    wide, narrow = (
        printed(own, "--full", env={"COLUMNS": str(columns)}).split("Configuration and provenance")[0]
        for columns in (200, 60)
    )
    assert max(map(len, narrow.splitlines())) <= 60
    numbers = r"(?<![\w.])[+-]?\d+\.\d+(?![\w.])"
    assert set(re.findall(numbers, narrow)) >= set(re.findall(numbers, wide))
