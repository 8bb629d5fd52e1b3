"""The table of ``hydrofdi measure``: errors in the unit of their estimates, small lengths in µm."""

import numpy as np

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.record_measures import Column, RecordMeasures
from hydrofdi.report.forms.measures import measures_table


def shown(**numbers):
    """The table of one record; the numbers are given as ``name: (unit, value)``."""
    columns = [Column("k", Output(name, unit, name), unit, ()) for name, (unit, _) in numbers.items()]
    values = {f"k.{name}": np.array(value) for name, (_, value) in numbers.items()}
    record = RecordMeasures(
        record_id="r", source="", group="", label="", status="ok", values=values, reasons={}
    )
    return repr(measures_table(columns, [record]))


def test_an_error_is_shown_in_the_unit_of_its_estimate():
    text = shown(bulk_modulus=("Pa", 601.1e6), bulk_modulus_error=("Pa", 1.276e6))
    assert "kPa" not in text
    assert "1.276" in text


def test_a_small_length_is_shown_in_micrometres():
    text = shown(offset=("m", 0.3089e-6), stroke=("m", 0.05))
    assert "µm" in text
    assert "0.3089" in text
    assert "mm" in text
    assert "50" in text
