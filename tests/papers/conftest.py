from tests.report.conftest import break_cell, made_up, paper, paper_analysis  # noqa: F401
