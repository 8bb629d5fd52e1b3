"""The table of ``hydrofdi measure``: errors in the unit of their estimates, small lengths in µm."""

import numpy as np
import pytest

from hydrofdi.cli.records.measures_table import print_measures
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.record_measures import Column, RecordMeasures


@pytest.fixture
def shown(capsys, monkeypatch):
    """Print a table of one record; the numbers are given as ``name: (unit, value)``."""
    monkeypatch.setenv("COLUMNS", "200")

    def show(**numbers):
        columns = [Column("k", Output(name, unit, name), unit, ()) for name, (unit, _) in numbers.items()]
        values = {f"k.{name}": np.array(value) for name, (_, value) in numbers.items()}
        record = RecordMeasures(
            record_id="r", source="", group="", label="", status="ok", values=values, reasons={}
        )
        print_measures(columns, [record])
        return capsys.readouterr().out.splitlines()

    return show


def test_an_error_is_shown_in_the_unit_of_its_estimate(shown):
    lines = shown(bulk_modulus=("Pa", 601.1e6), bulk_modulus_error=("Pa", 1.276e6))
    assert "kPa" not in "\n".join(lines)
    assert "1.276" in "\n".join(lines)


def test_a_small_length_is_shown_in_micrometres(shown):
    text = "\n".join(shown(offset=("m", 0.3089e-6), stroke=("m", 0.05)))
    assert "µm" in text
    assert "0.3089" in text
    assert "mm" in text
    assert "50" in text
