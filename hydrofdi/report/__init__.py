"""Tables, sections and figures made from experiments."""

from hydrofdi.report.analysis import Analysis, analyze
from hydrofdi.report.composition import Report
from hydrofdi.report.runs.rows import TableRow
from hydrofdi.report.runs.summary import summarize_table
from hydrofdi.report.runs.table import SensitivityTable

__all__ = ["Analysis", "Report", "SensitivityTable", "TableRow", "analyze", "summarize_table"]
