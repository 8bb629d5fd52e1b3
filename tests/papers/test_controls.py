import math

import pytest

from hydrofdi.papers.maddahi2015.controls import alarm
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.papers.maddahi2015.study import study_experiment
from hydrofdi.store.layout import names


def text_of(analysis, key):
    (block,) = [block for block in StudyReport(analysis).document().blocks if block.key == key]
    return " ".join(block.paragraphs)


def sealed_row(data, beta):
    return int(study_experiment(data).grid.positions[0, 0, beta])


def test_the_rule_alarms_where_the_bulk_modulus_alone_lowers_d3(paper_analysis):
    assert [round(each.row.bulk_modulus / 1e6) for each in paper_analysis.sealed] == [689, 827]
    for delta in (each.row.details.fixed for each in paper_analysis.sealed):
        assert alarm(delta) == (delta[2] > 0 and max(delta) == delta[2])


def test_the_rule_is_silent_where_d3_rises_and_the_sentence_says_so(paper, break_cell):
    data = paper
    for beta in (1, 2):
        data = break_cell(data, sealed_row(paper, beta), 2, 1e9)
    analysis = study_experiment(data)
    assert [alarm(each.row.details.fixed) for each in analysis.sealed] == [False, False]
    assert "silent in 2" in text_of(analysis, "controls")


def test_the_rule_is_silent_where_d3_falls_but_another_level_falls_more(paper, break_cell):
    position = sealed_row(paper, 1)
    analysis = study_experiment(break_cell(paper, position, 0, 1.0))
    assert analysis.sealed[0].row.details.fixed[2] > 0.0
    assert alarm(analysis.sealed[0].row.details.fixed) is False


def test_a_failed_control_is_open_and_no_silence(paper, break_cell):
    analysis = study_experiment(break_cell(paper, sealed_row(paper, 1), slice(None), math.nan))
    assert [alarm(each.row.details.fixed) for each in analysis.sealed] == [None, True]
    assert "alarm in 1 and open in 1" in text_of(analysis, "controls")


def test_the_best_level_is_the_one_that_the_table_marks(paper_analysis):
    rows = {(r.leakage_flow, r.bulk_modulus): r for r in paper_analysis.table.rows if not r.is_sealed}
    assert len(paper_analysis.leaky) == len(rows) == 9
    for mode in paper_analysis.leaky:
        delta = rows[mode.row.leakage_flow, mode.row.bulk_modulus].details.matched
        assert delta[mode.best_level] == max(delta) == mode.best_delta


def test_the_best_level_follows_a_changed_cell(paper, break_cell):
    position = int(study_experiment(paper).grid.positions[0, 1, 1])
    rms = paper.columns[names.DETAIL_RMS][position, 4]
    analysis = study_experiment(break_cell(paper, position, 4, 0.5 * rms))
    (mode,) = [m for m in analysis.leaky if m.best_delta == pytest.approx(50.0, abs=1.0)]
    assert mode.best_level == 4
    assert "d5 in 1" in text_of(analysis, "controls")
