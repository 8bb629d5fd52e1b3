"""Tables, sections and figures made from experiments."""

from hydrofdi.report.analysis import Analysis, analyze
from hydrofdi.report.composition import Report
from hydrofdi.report.runs.table import SensitivityTable, TableRow, summarize_table

__all__ = ["Analysis", "Report", "SensitivityTable", "TableRow", "analyze", "summarize_table"]
