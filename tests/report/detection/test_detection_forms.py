"""The report of a judged study, in every form."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.cli.tables import print_document
from hydrofdi.evaluation.scores import Kind
from hydrofdi.report.detection.answer import answer_block, answer_sentence, remarks_with_counts
from hydrofdi.report.detection.wording import best_with_sensors, sensors
from hydrofdi.report.forms.page import render_markdown, render_page
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Rules
from tests.report.detection.made_up import P1, P2, U, judged, made_up_records, made_up_score, report_of
from tests.report.rows import rows


@pytest.fixture(scope="module")
def document(detection):
    return report_of(detection).document()


def plain(text):
    """A form without its marks."""
    text = re.sub(r"<[^>]*>", " ", text).replace("&gt;", ">")
    return " ".join(text.replace("*", "").split())


def terminal(document, capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    print_document(document, "made_up.h5", full=True)
    return capsys.readouterr().out


def test_all_forms_say_the_same_numbers(detection, document, capsys, monkeypatch):
    forms = {
        "terminal": terminal(document, capsys, monkeypatch, 160),
        "markdown": render_markdown(document),
        "page": render_page(document, {}, dict.fromkeys(document.figures, "")),
    }
    texts = {name: plain(form) for name, form in forms.items()}
    sheets = {sheet.key: sheet for block in document.blocks for sheet in block.tables}
    for key in ("best", "scores", "shifts", "confusions", "levels"):
        for row in rows(sheets[key]):
            for name, text in texts.items():
                for number in row[1:]:
                    assert plain(number) in text, (name, key, number)
    for text in texts.values():
        assert plain(answer_sentence(detection)) in text


def test_the_terminal_fits_into_eighty_columns(document, capsys, monkeypatch):
    lines = terminal(document, capsys, monkeypatch, 80).splitlines()
    assert max(map(len, lines)) <= 80
    assert not any(line.endswith(" ") or "!*" in line for line in lines)


def test_the_answer_has_the_best_of_each_set_of_sensors(detection):
    (table,) = answer_block(detection).tables
    assert [row[0] for row in rows(table)][:3] == ["P1 P2 x u", "P1 P2 u", "P1"]
    assert "flow_balance.leakage_coefficient finds 0.0" in answer_sentence(detection)


def test_a_score_that_does_not_keep_its_rate_is_no_answer(detection):
    """Kurtosis finds less than all others with P1, and alarms in every shift."""
    kurtosis = next(each for each in detection.judgements if each.scored.name.endswith("kurtosis"))
    assert not kurtosis.keeps_its_rate
    assert "kurtosis" not in str(rows(answer_block(detection).tables[0]))
    assert "kurtosis ↑ !" in render_markdown(report_of(detection).document())


def hopeless(records):
    return [made_up_score(records, "noise", gain=0.0, channels=(P1, U))]


def alarming(records):
    return [made_up_score(records, "noise", gain=9.0, shift=9.0, channels=(P1, U))]


@pytest.mark.parametrize(
    ("chosen", "key"),
    [
        ({"scores": hopeless}, "no leakage up to 1 L/min"),
        ({"n_healthy": 20}, "set study.healthy.fit to 199, and study.healthy.test to 299 (20 now)"),
        ({"severities": ()}, "set study.faults"),
    ],
)
def test_where_nothing_is_found_the_answer_says_why(chosen, key):
    sentence = answer_sentence(judged(**chosen))
    assert sentence.startswith("Nothing is found")
    assert key in sentence


@pytest.mark.parametrize(
    ("chosen", "keeps", "why"),
    [({"n_healthy": 200}, None, "299 records of each"), ({"scores": alarming}, False, "study.population")],
)
def test_what_is_found_at_an_unknown_or_exceeded_rate_is_said_with_its_reservation(chosen, keeps, why):
    detection = judged(**chosen)
    sentence = answer_sentence(detection)
    assert detection.judgements[0].keeps_its_rate is keeps
    assert f"{detection.judgements[0].scored.name} finds 0." in sentence
    assert why in sentence.partition(", but ")[2]


def test_what_is_asked_is_said_in_its_own_numbers():
    detection = judged(rules=Rules(false_alarm_rate=0.05, confidence=0.9, probability=0.8))
    said = answer_sentence(detection)
    assert "in 80 % of all cases (90 % confidence) at a false-alarm rate of 5 %" in said


def test_the_smallest_tested_level_is_a_limit():
    def easy(records):
        return [made_up_score(records, "easy", gain=900.0, channels=(P1,))]

    detection = judged(scores=easy)
    assert "L/min or less" in answer_sentence(detection)
    assert rows(answer_block(detection).tables[0])[0][2].startswith("≤ 0.0")


def test_a_name_is_no_part_of_the_verdict(detection):
    """Renaming a score changes nothing but its name."""
    judgement = detection.judgements[0]
    renamed = replace(judgement, scored=replace(judgement.scored, name="other"))
    other = replace(detection, judgements=(renamed, *detection.judgements[1:]))
    other = replace(other, pareto=detection.pareto - {judgement.scored.name} | {"other"})
    assert (
        answer_sentence(other).casefold()
        == answer_sentence(detection).replace(judgement.scored.name, "other").casefold()
    )


def test_the_answer_names_no_sensors_that_are_not_needed(detection):
    first = detection.judgements[0]
    dominated = replace(detection, pareto=detection.pareto - {first.scored.name})
    assert first.scored.name not in answer_sentence(dominated)


def first_page(detection):
    block = answer_block(detection)
    return " ".join(block.paragraphs), block.tables[0]


@pytest.mark.parametrize("chosen", [{}, {"n_healthy": 200}, {"n_healthy": 20}])
def test_every_set_of_sensors_has_a_row(chosen):
    detection = judged(**chosen)
    _, sheet = first_page(detection)
    assert {row[0] for row in rows(sheet)} == {sensors(each) for each in detection.judgements}
    ranks = [
        next(rank for rank, each in enumerate(detection.judgements) if row[1].startswith(each.scored.name))
        for row in rows(sheet)
    ]
    best = ranks[: len({sensors(each) for each in detection.judgements})]
    assert best == sorted(best)


def test_the_best_score_has_a_row_if_its_false_alarms_are_unknown():
    detection = judged(n_healthy=200)
    text, sheet = first_page(detection)
    first = detection.judgements[0]
    assert first.keeps_its_rate is None
    assert f"{first.scored.name} finds" in text
    assert rows(sheet)[0][1].startswith(first.scored.name)


def study(*scores, **chosen):
    records = made_up_records(**chosen)
    return detect(records, [score(records) for score in scores], Rules())


def found(records):
    return made_up_score(records, "found", gain=200.0, channels=(P1, P2, U))


def test_a_score_exceeds_its_rate_where_its_interval_lies_above_what_is_allowed():
    for judgement in judged().judgements:
        allowed = judgement.threshold.interval[1]
        expected = [each for each, rate in judgement.false_alarms.items() if rate.low > allowed]
        assert list(judgement.exceeded) == expected
        is_shown = any(each.kind is not Kind.CONFUSION for each in expected)
        assert is_shown == (judgement.keeps_its_rate is False)
        assert np.isfinite(allowed)


def worse(records):
    return made_up_score(records, "worse", gain=3.0, seed=4, channels=(P1, P2, U))


def good(records):
    return made_up_score(records, "good", gain=200.0, seed=5, channels=(P1,))


def test_more_sensors_never_find_less():
    detection = study(good, worse)
    assert {each.scored.name for each in best_with_sensors(detection).values()} == {"good"}
    text, sheet = first_page(detection)
    assert [row[1] for row in rows(sheet)] == ["good"]
    assert "P2 and u would not help" in text


def test_remarks_that_are_equally_frequent_keep_their_order():
    detection = judged()
    said = tuple(f"remark {k}" for k in range(20))
    best = replace(detection.judgements[0], remarks=(*said, said[0]))
    told = remarks_with_counts(replace(detection, judgements=(best, *detection.judgements[1:])))
    assert [each.partition(" (")[0] for each in told if each.startswith("remark ")] == [*said]
