"""Tables, verdicts and figures made from experiments."""

from hydrofdi.report.analysis import Analysis, analyze
from hydrofdi.report.claims import CLAIMS, Claim, Verdict
from hydrofdi.report.composition import compose_report
from hydrofdi.report.table import SensitivityTable, TableRow, summarize_table

__all__ = [
    "CLAIMS",
    "Analysis",
    "Claim",
    "SensitivityTable",
    "TableRow",
    "Verdict",
    "analyze",
    "compose_report",
    "summarize_table",
]
