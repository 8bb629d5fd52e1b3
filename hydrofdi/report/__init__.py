"""Tables and figures made from experiment files."""

from hydrofdi.report.formats import render_csv, render_json, render_latex, render_markdown, table_record
from hydrofdi.report.table import SensitivityTable, TableRow, summarize_table

__all__ = [
    "SensitivityTable",
    "TableRow",
    "render_csv",
    "render_json",
    "render_latex",
    "render_markdown",
    "summarize_table",
    "table_record",
]
