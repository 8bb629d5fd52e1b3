"""The sentences that answer a study of delays."""

from dataclasses import replace

from hydrofdi.report.run_lengths import run_lengths_block, time_text
from hydrofdi.studies.charts import RunLengths
from tests.report.rows import rows
from tests.studies.test_run_lengths import EVERY, TEST, judged, traces


def block(of, every=EVERY):
    sums = [replace(chart, label="sums") for chart in judged(of, every, chart="cusum", shift=4)]
    charts = [*judged(of, every), *sums]
    return run_lengths_block(RunLengths(of.records, tuple(charts), 0.95, 0.9))


def answer(of, every=EVERY):
    return " ".join(block(of, every).paragraphs).partition(" Charts leave out")[0]


def too_loud():
    whole = traces()
    is_test = whole.records.of_record == whole.records.populations.index(TEST)
    whole.values[is_test] *= 3.0
    return whole


def test_the_answer_states_the_quickest_chart_with_its_interval():
    told = answer(traces())
    assert " 1.5 (1.5–1.5) s at 1 (own, whose healthy test records alarm once in " in told


def test_the_answer_is_that_of_the_longest_time_that_has_a_limit():
    """Whatever has none is named once for all charts, with the reason."""
    told = block(traces(), [EVERY, 1e6])
    assert "16.7 min" in told.paragraphs[0]
    assert told.paragraphs[-1].startswith("own and sums at one false alarm in 278 h")


def test_without_any_limit_no_leak_is_blamed():
    assert answer(traces(), 1e6) == "No delay is stated: no chart has a limit."


def test_times_stand_in_the_unit_that_a_person_reads():
    texts = [time_text(each) for each in (5.4, 60.0, 150.0, 3600.0, 3.1536e7)]
    assert texts == ["5.4 s", "1 min", "2.5 min", "1 h", "8,760 h"]
    delays, alarms = block(too_loud()).tables
    assert {row[1] for row in rows(delays)} == {"16.7 min"}
    measured = [row[5] for row in rows(alarms)]
    assert all(" s (" in each for each in measured)
