"""A section for each indicator, made from outputs chosen by hand."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.cli.tables import print_document
from hydrofdi.indicators import make_indicators
from hydrofdi.papers import make_report
from hydrofdi.report.forms.page import render_markdown, render_page
from hydrofdi.report.indicators import healthy_spread, measured_indicator, relative_change
from hydrofdi.report.table import Table
from hydrofdi.store.layout import names
from tests.report.rows import rows

FREQUENCIES = [60.0, 66.0, 59.4, 66.0, np.nan, np.nan]
"""Of the sealed runs at 551 and 689 MPa, with 0.12 L/min, and with 2 L/min, which has none and failed."""

LABEL, KIND = "ring", "ring_down"


@pytest.fixture
def with_ring(made_up):
    """The experiment of six runs, and its report with an indicator that is measured of the first four."""

    def report(data=made_up, frequencies=FREQUENCIES):
        (indicator,) = make_indicators({LABEL: {"kind": KIND}}).values()
        columns = {
            f"{LABEL}.{output.name}": np.where(np.isnan(frequencies), np.nan, 0.02)
            for output in indicator.outputs
        } | {f"{LABEL}.frequency": np.array(frequencies)}
        study = measured_indicator(LABEL, indicator, replace(data, columns=data.columns | columns))
        made = make_report(data)
        vars(made.analysis)["indicators"] = (study,)
        return made

    return report


def block_of(report):
    (block,) = [block for block in report.document().blocks if block.key == "indicators"]
    return block


def lines_of(report):
    return list(csv.DictReader(io.StringIO(Table.of(report.columns()).to_csv())))


def replicated(made_up):
    """Four more runs: healthy replicates of the sealed run at 551 MPa."""
    of = [0, 1, 2, 3, 4, 5, 0, 0, 0, 0]
    columns = {name: values[of] for name, values in made_up.columns.items()}
    columns[names.REPLICATE_OF] = np.array([-1] * 6 + [0] * 4)
    return replace(made_up, columns=columns)


def test_changes_within_those_of_healthy_replicates_are_marked(with_ring, made_up):
    report = with_ring(replicated(made_up), [*FREQUENCIES, 59.0, 61.0, 60.0, 60.0])
    (output, *_) = report.record()["indicators"][0]["outputs"]
    assert output["healthy"] == [60.0, 60.0]
    assert output["healthy_change"] == pytest.approx([59 - 181 / 3, 61 - 179 / 3])
    sheet = next(sheet for sheet in block_of(report).tables if sheet.key == "indicator-ranges")
    assert rows(sheet)[0][2:4] == ["4", "60"]
    first, *_, leaking = (
        each for each in lines_of(report) if each["ring.frequency [Hz]"] in ("60.0", "59.4")
    )
    assert float(first["ring.frequency change_fixed healthy_low [Hz]"]) == pytest.approx(59 - 181 / 3)
    assert float(leaking["ring.frequency change_fixed [%]"]) == pytest.approx(-1.0)
    assert first["ring.frequency change_fixed within_healthy"] == "1"


def test_every_form_has_the_section(with_ring, made_up, capsys):
    report = with_ring()
    document = report.document()
    print_document(document, made_up.path, full=True)
    for text in (
        capsys.readouterr().out,
        render_markdown(document),
        render_page(document, {}, {}),
    ):
        assert "ring (ring_down)" in text
        assert "natural frequency f_h" in text
    record = json.loads(json.dumps(report.record(), allow_nan=False))
    assert {row["indicators"]["ring.frequency"] for row in record["rows"]} == {60.0, 66.0, 59.4, None}
    assert record["indicators"][0]["not_measured"][1]["why"] == "diverged"
    by_run = {line["run_id"]: line for line in lines_of(report)}
    assert by_run[f"{1:016x}"]["ring.frequency [Hz]"] == "66.0"
    assert float(by_run[f"{1:016x}"]["ring.frequency change_fixed [%]"]) == pytest.approx(10.0)
    assert by_run[f"{5:016x}"]["ring.frequency [Hz]"] == ""


def test_without_further_indicators_nothing_is_added(made_up):
    report = make_report(made_up)
    assert not [block for block in report.document().blocks if block.key.startswith("indicator")]
    assert "indicators" not in report.record()


def test_a_change_is_relative_to_the_size_of_the_healthy_value():
    values = np.array([-2.0, -1.0, 0.0, 3.0])
    np.testing.assert_allclose(relative_change(np.full(4, -2.0), values), [0.0, 50.0, 100.0, 250.0])
    assert np.isnan(relative_change(np.zeros(4), values)).all(), "nothing is relative to zero"


def test_a_spread_needs_two_replicates(made_up):
    data = replicated(made_up)
    values = np.array([*FREQUENCIES, 60.0, np.nan, np.nan, np.nan])
    assert np.isnan(healthy_spread(values, data).mean).all()


def test_changes_of_a_number_near_zero_stand_in_its_own_unit(with_ring):
    report = with_ring(frequencies=[1e-7, 66.0, 5.0, 66.0, np.nan, np.nan])
    line = next(each for each in lines_of(report) if each["ring.frequency [Hz]"] == "5.0")
    assert line["ring.frequency change_fixed [%]"] == ""
    assert float(line["ring.frequency change_fixed [Hz]"]) == pytest.approx(5.0)


def test_a_healthy_value_within_the_width_of_its_replicates_is_near_zero():
    healthy, values = np.full(2, 1.0), np.array([1.0, 2.0])
    assert np.isnan(relative_change(healthy, values, width=np.full(2, 1.5))).all()
