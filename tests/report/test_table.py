"""The one table: the same numbers in every form."""

import csv
import io
import math

import numpy as np
import pytest

from hydrofdi.errors import UnknownNameError
from hydrofdi.report.table import Column, Table, quantity


@pytest.fixture
def table():
    return Table(
        (
            Column("record", ["a|b", "c*"], is_text=True),
            Column("flow", np.array([1.25e-5, math.nan]), "m^3/s", "Flow [L/min]", lambda q: f"{q * 6e4:g}"),
            Column("n", [3, None], strong=(0,)),
            Column("rms", np.arange(4.0).reshape(2, 2), "Pa", dims=("level",)),
        ),
        title="Records",
        row="record",
        notes=("a note",),
    )


def test_missing_numbers_are_none_for_programs(table):
    assert table.to_dict()["flow"] == [1.25e-5, None]
    assert [*table][1] == {"record": "c*", "flow": None, "n": None, "rms": [2.0, 3.0]}


def test_csv_gives_the_numbers_back(table):
    rows = [*csv.DictReader(io.StringIO(table.to_csv()))]
    assert float(rows[0]["flow"]) == 1.25e-5
    assert rows[1]["flow"] == ""


def test_people_read_headings_and_texts_and_not_the_arrays(table):
    assert [column.heading for column in table.shown] == ["record", "Flow [L/min]", "n"]
    assert next(table.texts()) == [("a|b", False), ("0.75", False), ("3", True)]


def test_markdown_keeps_its_columns_whatever_the_texts_contain(table):
    lines = table.to_markdown().splitlines()
    assert [line.replace(r"\|", "").count("|") for line in lines] == [4] * 4
    assert "**3**" in lines[2]
    assert r"c\*" in lines[3]


def test_html_escapes_texts(table):
    shown = Table((Column("name", ["<script>"]),)).to_html()
    assert "<script>" not in shown
    assert "&lt;script&gt;" in shown


def test_data_frames_and_data_sets_have_all_numbers(table):
    assert [*table.to_pandas().columns] == ["record", "flow", "n", "rms.0", "rms.1"]
    assert table.to_csv().splitlines()[0] == "record,flow,n,rms.0,rms.1"
    dataset = table.to_xarray()
    assert dataset["rms"].dims == ("record", "level")
    assert dataset["flow"].attrs == {"units": "m^3/s"}


def test_parquet_gives_the_numbers_back(table, tmp_path):
    from pyarrow import parquet

    (tmp_path / "t.parquet").write_bytes(table.to_parquet())
    assert parquet.read_table(tmp_path / "t.parquet")["flow"].to_pylist() == [1.25e-5, None]


def test_a_quantity_is_read_in_a_unit_that_suits_its_largest_value_or_given_sizes():
    assert quantity("p", [8.6e6, None], "Pa").heading == "p [MPa]"
    small = quantity("p_error", [1.25e4], "Pa", sizes=[8.6e6])
    assert (small.heading, small.text_of(0), small.listed) == ("p_error [MPa]", "0.0125", [1.25e4])


def test_columns_are_arrays_and_the_table_lists_their_names(table):
    assert table.columns == ["record", "flow", "n", "rms"]
    assert table["n"].tolist()[0] == 3.0
    assert np.isnan(table["n"][1])
    mixed = Table.of({"alarm": [True, None], "fault": ["", ""]})
    assert mixed["alarm"].tolist() == [True, None]
    assert [each.name for each in mixed.shown] == ["alarm"]


def test_an_unknown_column_is_an_error_of_the_user(table):
    with pytest.raises(UnknownNameError):
        table["flwo"]
