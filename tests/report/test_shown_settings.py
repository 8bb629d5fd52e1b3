"""The configuration in a report: what the experiment sets; its other settings are folded."""

import re

import pytest

from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

OWN = """\
name: own
record: {duration: 1 s}
store: {signals: none}
indicators: [dwt, modwt]
fluid: {vapour_pressure: 12 kPa}
sweep: {grid: {leakage.internal_flow: [0.2 L/min], supply.pressure: [12 MPa, 15 MPa]}}
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("own"), OWN)


def test_full_shows_what_the_experiment_sets_and_where_the_rest_is(own):
    full = run_hydrofdi("report", own.directory, "--full").stdout
    _, settings = full.split("What the experiment sets")
    for key, value in (
        ("record.duration", "1 s"),
        ("fluid.vapour_pressure", "12 kPa"),
        ("indicators.modwt", "default options"),
        ("sweep.grid", "leakage.internal_flow: 0.2 L/min; supply.pressure: 12 MPa, 15 MPa"),
    ):
        assert re.search(rf"^{re.escape(key)} +{re.escape(value)}", settings, re.MULTILINE), key
    assert settings.count("\n") > 100


def test_the_page_folds_the_default_values_and_its_tables_take_the_keyboard(own, tmp_path):
    page = tmp_path / "own.html"
    assert run_hydrofdi("report", own.directory, "--html", page).returncode == 0
    text = page.read_text()
    (folded,) = re.findall(r"<details>(.*?)</details>", text, re.DOTALL)
    assert "12.3 kg" in folded
    assert "12 kPa" not in folded
    assert "12 kPa" in text
    tables = re.findall(r'<div class="table[^>]*>', text)
    assert len(tables) == text.count("<table")
    assert all('role="region"' in each and 'tabindex="0"' in each and "aria-label" in each for each in tables)
