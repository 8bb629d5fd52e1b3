"""What ``hydrofdi report`` writes, and how it ends."""

import json

import pytest

CLAIMS = """\
name: claims
record: {duration: 2 s}
paper: maddahi2015
claims: [C2]
store: {signals: none}
sweep:
  grid:
    leakage.internal_coefficient: [0, 1e-9, 1e-8]
    fluid.bulk_modulus: [551 MPa, 600 MPa, 689 MPa]
"""


def test_check_ends_with_0_where_the_listed_claims_hold_and_with_1_where_one_does_not(
    hydrofdi, experiment_file
):
    hydrofdi("sweep", experiment_file(CLAIMS), "--engine", "in-process")
    claims = json.loads(hydrofdi("report", "--json").stdout)["claims"]
    outcomes = {claim["id"]: claim["reproduced"] for claim in claims}
    assert outcomes["C2"] is True
    broken = next(name for name, outcome in outcomes.items() if outcome is False)
    held = hydrofdi("report", "--check")
    assert (held.returncode, held.stdout) == (0, "")
    assert held.stderr.startswith("C2 holds: ")
    hydrofdi("sweep", experiment_file(CLAIMS.replace("[C2]", f"[C2, {broken}]")), "--engine", "in-process")
    failed = hydrofdi("report", "--check")
    assert failed.returncode == 1
    assert f"{broken} does not hold: " in failed.stderr


def test_the_study_of_the_paper_passes_its_own_check(hydrofdi, table3):
    result = hydrofdi("report", table3.directory, "--check")
    assert result.returncode == 0, result.stderr
    assert len(result.stderr.splitlines()) == 6


@pytest.mark.parametrize(
    "arguments",
    [("page.html", "--html"), ("--html",), ("page.html", "--format", "html"), ("--format", "html")],
)
def test_the_page_goes_where_it_is_wanted(hydrofdi, small_sweep, tmp_path, arguments):
    result = hydrofdi("report", small_sweep.directory, *arguments)
    page = tmp_path / "page.html" if "page.html" in arguments else small_sweep.directory / "small.html"
    assert (result.returncode, result.stdout) == (0, "")
    assert f"wrote {page.name if 'page.html' in arguments else page}" in result.stderr
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.parametrize(
    ("name", "start"),
    [("spectrum.svg", b"<?xml"), ("sensitivity.pdf", b"%PDF"), ("responses.png", b"\x89PNG")],
)
def test_the_name_of_a_figure_chooses_what_is_drawn_and_how(hydrofdi, table3, tmp_path, name, start):
    result = hydrofdi("report", table3.directory, "--figure", name)
    assert (tmp_path / name).read_bytes().startswith(start)
    assert f"drew {name}: " in result.stderr


def test_claims_that_change_need_no_run_again(hydrofdi, experiment_file):
    hydrofdi("sweep", experiment_file(CLAIMS), "--engine", "in-process")
    again = hydrofdi(
        "sweep", experiment_file(CLAIMS.replace("[C2]", "[C1]")), "--engine", "in-process", "--json"
    )
    assert json.loads(again.stdout)["completed"] == 0
    assert json.loads(hydrofdi("report", "--json").stdout)["guarded_claims"] == ["C1"]
