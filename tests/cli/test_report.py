import json
import os
import re
import shutil

from tests.commands import run_hydrofdi
from tests.conftest import sweep_in


def test_without_a_folder_the_newest_experiment_is_reported(hydrofdi, small_sweep, failing_sweep, tmp_path):
    for position, sweep in enumerate([failing_sweep, small_sweep]):
        shutil.copytree(sweep.folder / "results", tmp_path / "results", dirs_exist_ok=True)
        os.utime(tmp_path / sweep.summary["file"], (1e9 + position, 1e9 + position))
    assert json.loads(hydrofdi("report", "--json").stdout)["experiment"] == "small"
    os.utime(tmp_path / failing_sweep.summary["file"], (2e9, 2e9))
    assert json.loads(hydrofdi("report", "--json").stdout)["experiment"] == "failing"


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


def test_the_name_of_a_figure_chooses_what_is_drawn_and_how(hydrofdi, table3, tmp_path):
    for file, start in (("figure3.svg", b"<?xml"), ("sensitivity.pdf", b"%PDF"), ("phases.png", b"\x89PNG")):
        result = hydrofdi("report", table3.directory, "--figure", file, "--json")
        assert (tmp_path / file).read_bytes().startswith(start)
        assert f"drew {file}: " in result.stderr
        assert json.loads(result.stdout)
    assert hydrofdi("report", table3.directory, "--figure", "sensitivity").returncode == 2
