import json
import os
import re
import shutil

import pytest

from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

LEAKAGES = (0.12, 0.89, 2.0)
BULK_MODULI = (551.0, 689.0, 827.0)


def test_the_table_is_nine_leaky_modes_and_three_sealed_controls(hydrofdi, table3, table3_rows):
    modes = {
        (round(row["leakage_L_per_min"], 9), round(row["bulk_modulus_MPa"], 6)): row for row in table3_rows
    }
    assert modes.keys() == {(leakage, beta) for leakage in (0.0, *LEAKAGES) for beta in BULK_MODULI}
    assert [modes[0.0, beta]["internal_leakage_coefficient"] for beta in BULK_MODULI] == [0.0] * 3
    for leakage in LEAKAGES:
        assert len({modes[leakage, beta]["internal_leakage_coefficient"] for beta in BULK_MODULI}) == 1
    at_baseline = [modes[leakage, 551.0]["mean_internal_leakage_L_per_min"] for leakage in LEAKAGES]
    assert at_baseline == pytest.approx(LEAKAGES, rel=1e-8)
    frequencies = [modes[0.0, beta]["hydraulic_mode_Hz"] for beta in BULK_MODULI]
    assert frequencies == sorted(frequencies)
    assert frequencies[0] == pytest.approx(59.64, abs=0.02)
    dampings = [modes[leakage, 551.0]["hydraulic_mode_damping_ratio"] for leakage in (0.0, *LEAKAGES)]
    assert dampings == sorted(dampings)
    checked = hydrofdi("report", table3.directory, "--check")
    assert (checked.returncode, len(checked.stderr.splitlines())) == (0, 6)


def test_without_a_folder_the_newest_experiment_is_reported(hydrofdi, small_sweep, failing_sweep, tmp_path):
    for position, sweep in enumerate([failing_sweep, small_sweep]):
        shutil.copytree(sweep.folder / "results", tmp_path / "results", dirs_exist_ok=True)
        os.utime(tmp_path / sweep.summary["file"], (1e9 + position, 1e9 + position))
    assert json.loads(hydrofdi("report", "--json").stdout)["experiment"] == "small"
    os.utime(tmp_path / failing_sweep.summary["file"], (2e9, 2e9))
    assert json.loads(hydrofdi("report", "--json").stdout)["experiment"] == "failing"


def test_a_failed_run_is_a_row_without_numbers(hydrofdi, failing_sweep):
    rows = json.loads(hydrofdi("report", failing_sweep.directory, "--json").stdout)["rows"]
    (failed,) = [row for row in rows if row["status"] != "ok"]
    assert failed["detail_rms_Pa"] == failed["delta_fixed_percent"] == [None] * 5
    for form in ("text", "markdown", "csv"):
        result = hydrofdi("report", failing_sweep.directory, "--format", form)
        assert result.returncode == 0
        assert not re.search(r"\bnan\b", result.stdout)
        assert "–" in result.stdout or form != "markdown"


def test_a_grid_over_the_coefficient_itself_gives_the_same_table(table3_rows, tmp_path):
    coefficients = list(dict.fromkeys(row["internal_leakage_coefficient"] for row in table3_rows))
    assert len(coefficients) == 4
    text = (
        "name: coefficients\nstore: {signals: none}\nsweep:\n  grid:\n"
        f"    leakage.internal_coefficient: {coefficients}\n    fluid.bulk_modulus: [551e6, 689e6, 827e6]\n"
    )
    sweep = sweep_in(tmp_path, text)
    rows = json.loads(run_hydrofdi("report", sweep.directory, "--json", cwd=tmp_path).stdout)["rows"]
    one, other = (
        {(row["internal_leakage_coefficient"], row["bulk_modulus_MPa"]): row for row in each}
        for each in (rows, table3_rows)
    )
    assert one.keys() == other.keys()
    for name in ("detail_rms_Pa", "delta_fixed_percent", "delta_matched_percent"):
        assert all(one[mode][name] == other[mode][name] for mode in one)


SAMPLED = """\
name: sampled
record: {duration: 1 s}
store: {signals: none}
sweep: {sample: {count: 128, over: {fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}}}
"""


def test_a_sampled_sweep_shows_quantiles_and_programs_get_every_run(tmp_path):
    sweep = sweep_in(tmp_path, SAMPLED)
    short, text, found, table = (
        run_hydrofdi("report", sweep.directory, *arguments, cwd=tmp_path).stdout
        for arguments in ((), ("--full",), ("--json",), ("--format", "csv"))
    )
    assert 0 < len(short.splitlines()) < 40
    assert "95 %" in text
    assert "ank correlation" in text
    assert len(json.loads(found)["rows"]) == 256
    assert len(table.splitlines()) == 1 + 5 * 256
    assert len(re.findall(r"^ +sealed ", text, re.M)) >= 256


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
    assert (held.returncode, held.stdout, held.stderr[:10]) == (0, "", "C2 holds: ")
    more = experiment_file(CLAIMS.replace("[C2]", f"[C2, {broken}]"))
    again = hydrofdi("sweep", more, "--engine", "in-process", "--json")
    assert json.loads(again.stdout)["completed"] == 0
    assert json.loads(hydrofdi("report", "--json").stdout)["guarded_claims"] == ["C2", broken]
    failed = hydrofdi("report", "--check")
    assert failed.returncode == 1
    assert f"{broken} does not hold: " in failed.stderr


def test_the_page_goes_where_it_is_wanted(hydrofdi, small_sweep, tmp_path):
    for arguments, page in (
        (("page.html", "--html"), tmp_path / "page.html"),
        (("--format", "html"), small_sweep.directory / "small.html"),
    ):
        result = hydrofdi("report", small_sweep.directory, *arguments)
        assert (result.returncode, result.stdout) == (0, "")
        assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_the_name_of_a_figure_chooses_what_is_drawn_and_how(hydrofdi, table3, tmp_path):
    for arguments, file, start in (
        (("figure3.svg", "--json"), "figure3.svg", b"<?xml"),
        (("sensitivity.pdf",), "sensitivity.pdf", b"%PDF"),
        (("sensitivity", "--out", "map.png"), "map.png", b"\x89PNG"),
    ):
        result = hydrofdi("report", table3.directory, "--figure", *arguments)
        assert (tmp_path / file).read_bytes().startswith(start)
        assert f"drew {file}: " in result.stderr
        assert bool(result.stdout) == ("--json" in arguments)
    assert hydrofdi("report", table3.directory, "--figure", "sensitivity").returncode == 2
