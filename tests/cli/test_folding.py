"""Long names are folded where a person would break them."""

import io

import pytest
from rich.console import Console

from hydrofdi.cli.tables import folded, print_table
from hydrofdi.report.table import Column, Table


@pytest.mark.parametrize(
    ("text", "width", "lines"),
    [
        ("cross_correlation.coefficient ↕", 14, ["cross_", "correlation.", "coefficient ↕"]),
        ("balance_P1.leakage ↑", 14, ["balance_P1.", "leakage ↑"]),
        ("the oil is stiffer by 4.5 MPa", 12, ["the oil is", "stiffer by", "4.5 MPa"]),
        ("dwt.d3", 14, ["dwt.d3"]),
        ("ring_down.damping ↕ !", 19, ["ring_down.", "damping ↕ !"]),
        ("unbreakablename", 6, ["unbrea", "kablen", "ame"]),
        ("", 6, [""]),
    ],
)
def test_a_text_is_broken_at_blanks_points_and_underscores(text, width, lines):
    assert folded(text, width) == lines


def test_a_table_breaks_no_part_of_a_name_at_80_columns():
    names = ["pressure_statistics.crest_factor_of_chamber_1 ↑", "cross_correlation.coefficient ↕"]
    numbers = [Column(f"column {number} [L/min]", ["3.3 (0.4–12)"] * 2, strong=(0,)) for number in range(5)]
    console = Console(file=io.StringIO(), width=80)
    print_table(console, Table((Column("Score", names, is_text=True), *numbers)))
    shown = {line.split("  ")[0].strip() for line in console.file.getvalue().splitlines()}
    parts = [part for name in names for part in name.replace("_", "_ ").replace(".", ". ").split()]
    assert max(map(len, console.file.getvalue().splitlines())) <= 80
    assert all(any(part in line for line in shown) for part in parts)
