import math

import pytest

from hydrofdi.papers.maddahi2015 import study_experiment
from hydrofdi.papers.maddahi2015.composition import compose_study
from hydrofdi.store.layout import names


def text_of(analysis, key):
    (block,) = [block for block in compose_study(analysis).blocks if block.key == key]
    return " ".join(block.paragraphs)


def sealed_row(data, beta):
    return int(study_experiment(data).grid.positions[0, 0, beta])


def test_the_rule_alarms_where_the_bulk_modulus_alone_lowers_d3(paper_analysis):
    assert [round(alarm.bulk_modulus / 1e6) for alarm in paper_analysis.sealed_alarms] == [689, 827]
    for alarm in paper_analysis.sealed_alarms:
        assert alarm.alarm == (alarm.delta_fixed[2] > 0 and max(alarm.delta_fixed) == alarm.delta_fixed[2])


def test_the_rule_is_silent_where_d3_rises_and_the_sentence_says_so(paper, break_cell):
    data = paper
    for beta in (1, 2):
        data = break_cell(data, sealed_row(paper, beta), 2, 1e9)
    analysis = study_experiment(data)
    assert [alarm.alarm for alarm in analysis.sealed_alarms] == [False, False]
    assert "raises no alarm in all 2 sealed cases" in text_of(analysis, "controls")


def test_the_rule_is_silent_where_d3_falls_but_another_level_falls_more(paper, break_cell):
    position = sealed_row(paper, 1)
    analysis = study_experiment(break_cell(paper, position, 0, 1.0))
    assert analysis.sealed_alarms[0].delta_fixed[2] > 0.0
    assert analysis.sealed_alarms[0].alarm is False


def test_a_failed_control_is_open_and_no_silence(paper, break_cell):
    analysis = study_experiment(break_cell(paper, sealed_row(paper, 1), slice(None), math.nan))
    assert [alarm.alarm for alarm in analysis.sealed_alarms] == [None, True]
    assert "in 1 of 1 cases" in text_of(analysis, "controls")


def test_the_best_level_is_the_one_that_the_table_marks(paper_analysis):
    rows = {(r.leakage_flow, r.bulk_modulus): r for r in paper_analysis.table.rows if not r.is_sealed}
    assert len(paper_analysis.best_levels) == len(rows) == 9
    for mode in paper_analysis.best_levels:
        delta = rows[mode.leakage_flow, mode.bulk_modulus].details.matched
        assert delta[mode.level] == max(delta) == mode.delta


def test_the_best_level_follows_a_changed_cell(paper, break_cell):
    position = int(study_experiment(paper).grid.positions[0, 1, 1])
    rms = paper.columns[names.DETAIL_RMS][position, 4]
    analysis = study_experiment(break_cell(paper, position, 4, 0.5 * rms))
    (mode,) = [m for m in analysis.best_levels if m.delta == pytest.approx(50.0, abs=1.0)]
    assert mode.level == 4
    assert "d5 in 1" in text_of(analysis, "controls")
