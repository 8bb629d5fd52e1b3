"""What figures show, compared by structure with ``golden/``. HYDROFDI_WRITE_GOLDEN=1 writes that anew."""

import json
import os
from pathlib import Path

import pytest

from hydrofdi.report.figures import draw_all, draw_figure
from hydrofdi.report.figures.style import figure_bytes
from tests.report.figures.structure import structure

GOLDEN = Path(__file__).parent / "golden"

COMPARED = [
    ("modes", "sensitivity"),
    ("modes", "spectrum"),
    ("modes", "mode_plane"),
    ("many", "responses"),
    ("scenarios", "scenarios"),
    ("study", "answer"),
    ("study", "ranking"),
    ("study", "pod"),
    ("delays", "delays"),
]


@pytest.mark.parametrize(("experiment", "name"), COMPARED)
def test_a_figure_shows_what_it_did(reports, experiment, name):
    found = structure(draw_figure(reports[experiment], name))
    golden = GOLDEN / f"{experiment}-{name}.json"
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        GOLDEN.mkdir(exist_ok=True)
        golden.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert found == json.loads(golden.read_text(encoding="utf-8"))


def test_the_lines_of_the_heat_map_are_the_runs_of_a_small_sweep(reports):
    drawn = structure(draw_figure(reports["modes"], "sensitivity"))
    table = reports["modes"].analysis.table
    assert drawn["axes"][0]["x"]["ticks"] == ["Leakage\n[L/min]", "EBM\n[MPa]"]
    assert drawn["axes"][0]["texts"][:4] == ["sealed", "400", "sealed", "551"]
    assert drawn["axes"][1]["cells"] == [[len(table), 5]]


def test_every_figure_can_be_drawn_and_saved(reports):
    for report in reports.values():
        drawn, _ = draw_all(report, list(report.figures()))
        assert drawn
        assert all(figure_bytes(figure, "svg") for figure in drawn.values())
