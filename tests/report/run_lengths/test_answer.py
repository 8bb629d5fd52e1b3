"""The sentence that answers a study of delays."""

from hydrofdi.report.run_lengths.block import run_lengths_block
from hydrofdi.studies.run_lengths.judgement import RunLengths
from tests.studies.test_run_lengths import TEST, judged, traces


def answer(of):
    charts = [*judged(of), *judged(of, chart="cusum", shift=4)]
    return run_lengths_block(RunLengths(of.records, tuple(charts), 0.95, 0.9)).paragraphs[0]


def test_the_answer_states_the_quickest_chart_with_its_interval():
    told = answer(traces())
    assert "one false alarm in 16.7 min of operation" in told
    assert "found by the quickest of 2 charts" in told
    assert " after 1.5 (1.5–1.5) s, own" in told


def test_charts_that_alarm_too_often_in_health_answer_nothing():
    whole = traces()
    is_test = whole.records.of_record == whole.records.populations.index(TEST)
    whole.values[is_test] *= 3.0
    assert answer(whole) == (
        "Healthy test records alarm more often than once in 16.7 min at every limit set for that."
    )
