"""Tables on narrow terminals: long names are folded where a person would break them, and no number is cut."""

import os
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
import typer.main
from rich.console import Console

from hydrofdi.api.detectors.training import setting_keys
from hydrofdi.cli.app import application
from hydrofdi.cli.tables import folded, print_table
from hydrofdi.report.table import Column, Table
from tests.commands import run_hydrofdi

NUMBER = re.compile(r"[-−+]?\d[\d.,]*(?:e[-+]\d+)?%?")
SWEEP = "record: {duration: 6 s}\nsweep: {grid: {fluid.bulk_modulus: [551 MPa, 689.123 MPa]}}\n"


@pytest.mark.parametrize(
    ("text", "width", "lines"),
    [
        ("cross_correlation.coefficient ↕", 14, ["cross_", "correlation.", "coefficient ↕"]),
        ("the oil is stiffer by 4.5 MPa", 12, ["the oil is", "stiffer by", "4.5 MPa"]),
        ("unbreakablename", 6, ["unbrea", "kablen", "ame"]),
        ("", 6, [""]),
    ],
)
def test_a_text_is_broken_at_blanks_points_and_underscores(text, width, lines):
    assert folded(text, width) == lines


@pytest.mark.parametrize(
    "command",
    [("check", "experiment.yaml", "--set", "indicators=weak_rls"), ("measure", "experiment.yaml")],
    ids=" ".join,
)
def test_no_number_of_a_command_is_cut_at_60_columns(monkeypatch, experiment_file, tmp_path, command):
    experiment_file(SWEEP)
    shown = []
    for width in ("400", "60"):
        monkeypatch.setenv("COLUMNS", width)
        shown.append(run_hydrofdi(*command, cwd=tmp_path).stdout)
    wide, narrow = (Counter(NUMBER.findall(text)).keys() for text in shown)
    assert {number for number in wide - narrow if "." in number} == set()


@pytest.mark.parametrize("width", [20, 60, 200])
def test_a_parted_table_shows_every_cell_whole_under_its_header(width):
    numbers = (
        Column(f"number {n}", [f"{run}.{n}2345" for run in range(3)], title=f"number {n} [unit]")
        for n in range(9)
    )
    console = Console(width=width)
    with console.capture() as captured:
        print_table(console, Table((Column("run", ["r0", "r1", "r2"], is_text=True), *numbers)))
    text = captured.get()
    assert all(f"{run}.{column}2345" in text for run in range(3) for column in range(9))
    assert all(f"number {column}" in text for column in range(9))
    assert max(map(len, text.splitlines())) <= width


def test_texts_from_outside_do_not_act_on_the_terminal(capsys):
    print_table(Console(width=80), Table((Column("name", ["a\x1b[31mred\x07"], is_text=True),)))
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", capsys.readouterr().out)


SCRIPT = Path(sys.executable).parent / "hydrofdi"


@pytest.mark.parametrize("command", [(), ("sweep",), ("measure",)])
def test_h_is_help(command):
    short, full = (run_hydrofdi(*command, option) for option in ("-h", "--help"))
    assert short.returncode == 0
    assert short.stdout == full.stdout


@pytest.mark.skipif(not SCRIPT.exists(), reason="the command is not installed beside Python")
def test_the_shell_completes_commands():
    asked = {"_HYDROFDI_COMPLETE": "complete_bash", "COMP_WORDS": "hydrofdi sw", "COMP_CWORD": "1"}
    done = subprocess.run([SCRIPT], env=os.environ | asked, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["sweep"]
    assert not done.stderr


def test_every_plain_setting_of_a_detector_is_an_option_of_train():
    command = typer.main.get_command(application(["train"])).commands["train"]
    options = {parameter.name for parameter in command.params}
    assert setting_keys().keys() - options == {"options", "indicators", "score"}


def test_commands_stand_in_groups():
    shown = run_hydrofdi("--help").stdout
    assert not {"Start:", "Study:", "Records:", "Live:", "Look up:", "Audit:"} - {*shown.splitlines()}
