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


def test_check_without_claims_to_check_is_a_mistake_of_the_user(hydrofdi, small_sweep):
    result = hydrofdi("report", small_sweep.directory, "--check")
    assert result.returncode == 2
    assert "list claims in the experiment file" in result.stderr


def test_an_unknown_claim_is_reported_with_its_line(hydrofdi, experiment_file):
    result = hydrofdi("sweep", experiment_file("name: a\nclaims: [C1, C7]\n"))
    assert result.returncode == 2
    assert "experiment.yaml:2: claims[1]: must be 'C1'" in result.stderr


def test_mistakes_in_published_values_are_reported_with_their_lines(hydrofdi, experiment_file):
    text = (
        "name: a\nreference:\n  cells:\n"
        "    - {leakage: 1 L/min, bulk_modulus: 551 MPa, level: d2}\n"
        "    - {leakage: 1 bar, bulk_modulus: 551 MPa, level: two, delta: 1}\n"
    )
    result = hydrofdi("sweep", experiment_file(text))
    assert result.returncode == 2
    assert "experiment.yaml:4: reference.cells[0]: give one of delta and rms" in result.stderr
    assert "experiment.yaml:5: reference.cells[1].leakage: '1 bar' has the wrong unit" in result.stderr
    assert "experiment.yaml:5: reference.cells[1].level: " in result.stderr


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


def test_a_page_without_html_is_a_mistake(hydrofdi, small_sweep, tmp_path):
    result = hydrofdi("report", small_sweep.directory, "page.html")
    assert result.returncode == 2
    assert "after --html" in result.stderr
    assert not (tmp_path / "page.html").exists()


@pytest.mark.parametrize(
    ("name", "start"),
    [("spectrum.svg", b"<?xml"), ("sensitivity.pdf", b"%PDF"), ("responses.png", b"\x89PNG")],
)
def test_the_name_of_a_figure_chooses_what_is_drawn_and_how(hydrofdi, table3, tmp_path, name, start):
    result = hydrofdi("report", table3.directory, "--figure", name)
    assert (tmp_path / name).read_bytes().startswith(start)
    assert f"drew {name}: " in result.stderr


def test_an_unknown_figure_is_refused_with_the_known_ones(hydrofdi, table3, tmp_path):
    result = hydrofdi("report", table3.directory, "--figure", "rok.png")
    assert result.returncode == 2
    assert len(result.stderr.splitlines()) == 1
    assert "sensitivity" in result.stderr
    assert not (tmp_path / "rok.png").exists()


def test_claims_that_change_need_no_run_again(hydrofdi, experiment_file):
    hydrofdi("sweep", experiment_file(CLAIMS), "--engine", "in-process")
    again = hydrofdi(
        "sweep", experiment_file(CLAIMS.replace("[C2]", "[C1]")), "--engine", "in-process", "--json"
    )
    assert json.loads(again.stdout)["completed"] == 0
    assert json.loads(hydrofdi("report", "--json").stdout)["guarded_claims"] == ["C1"]
