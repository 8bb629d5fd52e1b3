"""Faults of machines that another simulator made, none of which obeys the equations of the diagnosis."""

import csv

import pytest

import hydrofdi
from tests.conftest import FOREIGN, needs_foreign

pytestmark = needs_foreign


@pytest.fixture(scope="module")
def named():
    """Machine → the diagnosis of its records, with its own history."""
    return {
        machine: hydrofdi.diagnose(FOREIGN / f"{machine}_test.yaml", FOREIGN / f"{machine}_history.yaml")
        for machine in ("crane", "scored", "gap")
    }


def test_faults_of_a_crane_are_named_where_the_model_fits_badly(named):
    with (FOREIGN / "crane_truth.csv").open() as file:
        truth = [row["fault"].replace("return_pressure", "raised_return") for row in csv.DictReader(file)]
    found = [each.name for each in named["crane"].records]
    assert [name == "healthy" for name in found] == [name == "healthy" for name in truth]
    assert sum(one == other for one, other in zip(found, truth, strict=True)) >= 9


def test_a_scored_bore_is_named_or_stands_beside_none_of_these(named):
    first = [each.findings[0] for each in named["scored"].records]
    assert sum(each.name == "seal_scored" for each in first) >= 4
    assert all(
        "seal_scored" in (each.name, *each.looks_like) or each.name == "none_of_these" for each in first
    )
    assert {each.name for each in named["gap"].records} == {"seal_laminar"}
