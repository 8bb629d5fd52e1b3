"""No number of a table is cut on a narrow terminal: what does not fit is folded or goes below."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest
from rich.console import Console

from hydrofdi.cli.tables import print_table
from hydrofdi.report.table import Column, Table
from tests.commands import run_hydrofdi
from tests.conftest import sweep_in
from tests.monitor.machines import make_machine

SWEEP = """\
name: narrow
record: {duration: 6 s}
pressure_1_sensor: {noise: 20 kPa}
sweep: {grid: {fluid.bulk_modulus: [551 MPa, 689.123 MPa], leakage.internal_flow: [0, 0.2 L/min]}}
"""
COMMANDS = {
    "measure": ("measure", "{sweep}", "--indicators", "dwt,weak_rls,band_power"),
    "inspect": ("inspect", "{sweep}"),
    "indicators": ("indicators",),
    "indicator": ("indicators", "weak_rls"),
    "detect": ("detect", "{detector}", "{stream}"),
    "plan": ("plan", "{config}"),
    "check": ("check", "{config}"),
    "check estimators": ("check", "{config}", "--set", "indicators=weak_rls"),
    "check of a step": ("check", "{config}", "--converge"),
    "calibrate": ("calibrate", "{config}", "--flow", "0.12 L/min", "--flow", "0.1234567 L/min"),
    "why": ("why", "{sweep}", "1"),
    "configs": ("configs",),
    "simulate": ("simulate", "{config}"),
}  # fmt: skip
NUMBER = re.compile(r"[-−+]?\d[\d.,]*(?:e[-+]\d+)?%?")


@pytest.fixture(scope="module")
def places(tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("narrow")
    swept = sweep_in(folder, SWEEP)
    machine = make_machine(folder)
    stream = folder / "a-stream-with-a-name-that-is-longer-than-usual.csv"
    machine.stream.rename(stream)
    return {
        "sweep": swept.directory, "config": swept.config, "detector": machine.detector, "stream": stream
    }  # fmt: skip


def shown(monkeypatch, places: dict[str, Path], command: str, width: int) -> str:
    monkeypatch.setenv("COLUMNS", str(width))
    arguments = [each.format(**places) for each in COMMANDS[command]]
    done = run_hydrofdi(*arguments, cwd=places["config"].parent)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_no_number_is_cut_at_60_columns(monkeypatch, places, command) -> None:
    room = 105 if command == "indicators" else 400  # wider ones show the sources, too
    wide, narrow = (shown(monkeypatch, places, command, width) for width in (room, 60))
    assert narrow.count("…") <= wide.count("…")
    missing = Counter(NUMBER.findall(wide)).keys() - Counter(NUMBER.findall(narrow)).keys()
    assert {number for number in missing if "." in number} == set()


@pytest.mark.parametrize("width", [20, 40, 60, 200])
def test_a_parted_table_shows_every_cell_whole_under_its_header(width) -> None:
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
