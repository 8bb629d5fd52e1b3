import math

from hydrofdi.papers.maddahi2015.controls import alarm_verdicts, best_deltas
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.store.layout import names


def sealed_row(data, beta):
    return int(Study(data).grid.positions[0, 0, beta])


def test_the_rule_alarms_where_the_bulk_modulus_alone_lowers_d3(paper_analysis):
    sealed = paper_analysis.sealed
    assert [round(each / 1e6) for each in sealed[names.BULK_MODULUS]] == [689, 827]
    delta = sealed.changes("fixed")
    assert alarm_verdicts(delta) == [each[2] > 0 and max(each) == each[2] for each in delta]


def test_the_rule_is_silent_where_d3_rises_and_the_sentence_says_so(paper, break_cell):
    data = paper
    for beta in (1, 2):
        data = break_cell(data, sealed_row(paper, beta), 2, 1e9)
    analysis = Study(data)
    assert alarm_verdicts(analysis.sealed.changes("fixed")) == [False, False]


def test_the_rule_is_silent_where_d3_falls_but_another_level_falls_more(paper, break_cell):
    position = sealed_row(paper, 1)
    analysis = Study(break_cell(paper, position, 0, 1.0))
    delta = analysis.sealed.changes("fixed")
    assert delta[0, 2] > 0.0
    assert alarm_verdicts(delta)[0] is False


def test_a_failed_control_is_open_and_no_silence(paper, break_cell):
    analysis = Study(break_cell(paper, sealed_row(paper, 1), slice(None), math.nan))
    assert alarm_verdicts(analysis.sealed.changes("fixed")) == [None, True]


def test_the_best_level_is_the_one_that_the_table_marks(paper_analysis):
    leaky = paper_analysis.leaky
    assert len(leaky) == (~paper_analysis.table.is_sealed).sum() == 9
    for level, best, delta in zip(*best_deltas(leaky), leaky.changes("matched"), strict=True):
        assert delta[level] == max(delta) == best


def test_the_best_level_follows_a_changed_cell(paper, break_cell):
    position = int(Study(paper).grid.positions[0, 1, 1])
    rms = paper.columns[names.DETAIL_RMS][position, 4]
    analysis = Study(break_cell(paper, position, 4, 0.5 * rms))
    assert [k for k, d in zip(*best_deltas(analysis.leaky), strict=True) if abs(d - 50.0) < 1.0] == [4]
