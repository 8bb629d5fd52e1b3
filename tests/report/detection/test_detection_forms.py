"""The report of a judged study, in every form."""

import re
from dataclasses import replace

import pytest

from hydrofdi.cli.rendering import print_document
from hydrofdi.report.detection.answer import answer_block, answer_sentence
from hydrofdi.report.forms.markdown import render_markdown
from hydrofdi.report.forms.page import render_page
from hydrofdi.studies.rules import Rules
from tests.report.detection.made_up import P1, U, judged, made_up_score, report_of


@pytest.fixture(scope="module")
def document(detection):
    return report_of(detection).document()


def plain(text):
    """A form without its marks."""
    text = re.sub(r"<[^>]*>", " ", text)
    for mark, meaning in (("\\_", "_"), ("~", " "), ("\\textbf", "")):
        text = text.replace(mark, meaning)
    for mark in "$\\{}*":
        text = text.replace(mark, "")
    return " ".join(text.replace("--", "–").replace("&gt;", ">").replace("le ", "≤ ").split())


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
        for row in sheets[key].rows:
            numbers = [cell.text for cell in row[1:]]
            for name, text in texts.items():
                for number in numbers:
                    assert plain(number) in text, (name, key, number)
    for name in ("terminal", "markdown", "page"):
        assert plain(answer_sentence(detection)) in texts[name]


def test_the_terminal_fits_into_eighty_columns(document, capsys, monkeypatch):
    lines = terminal(document, capsys, monkeypatch, 80).splitlines()
    assert max(map(len, lines)) <= 80


def test_the_answer_names_the_best_of_each_set_of_sensors(detection):
    sentence = answer_sentence(detection)
    assert sentence.startswith("With P1, P2, x and u, flow_balance.leakage_coefficient finds 0.0")
    assert (
        "nine times in ten (95 % confidence) at thresholds set for one false alarm in a hundred (measured"
        in sentence
    )
    assert "with P1 alone, " in sentence


def test_a_score_that_does_not_keep_its_rate_is_no_answer(detection):
    """Kurtosis finds less than all others with P1, and alarms in every shift."""
    kurtosis = next(each for each in detection.judgements if each.scored.name.endswith("kurtosis"))
    assert not kurtosis.keeps_its_rate
    assert "kurtosis" not in answer_sentence(detection)
    assert "kurtosis ↑ !" in render_markdown(report_of(detection).document())


def test_wavelet_rules_are_answered_by_name_without_the_paper(detection):
    text = " ".join(answer_block(detection).paragraphs)
    assert "paper" not in render_markdown(report_of(detection).document())
    assert "dwt.d2 detects no leak up to 1 L/min" in text


def test_the_counts_are_those_of_the_records(detection):
    text = " ".join(answer_block(detection).paragraphs)
    assert "From 2,080 records: 400 healthy to set the thresholds" in text
    assert f"{len(detection.judgements)} scores were tried" in text


def hopeless(records):
    return [made_up_score(records, "noise", gain=0.0, channels=(P1, U))]


def alarming(records):
    return [made_up_score(records, "noise", gain=9.0, shift=9.0, channels=(P1, U))]


@pytest.mark.parametrize(
    ("chosen", "answer"),
    [
        ({"scores": hopeless}, "no leakage up to 1 L/min with any score."),
        (
            {"n_healthy": 20},
            "20 healthy records set it, 199 are needed; set study.healthy.fit to 199, and study.healthy.test"
            " to 299 (20 now) to measure the rate.",
        ),
        ({"severities": ()}, "no leaking record is tested; set study.faults."),
    ],
)
def test_where_nothing_is_found_the_answer_says_why(chosen, answer):
    sentence = answer_sentence(judged(**chosen))
    assert sentence.startswith("Nothing is found nine times in ten")
    assert sentence.endswith(answer)


def test_what_is_found_at_an_unknown_false_alarm_rate_is_said_with_its_reservation():
    detection = judged(n_healthy=200)
    first, sentence = detection.judgements[0], answer_sentence(detection)
    assert first.keeps_its_rate is None
    assert f"{first.scored.name} finds 0.0" in sentence
    assert "Nothing is found" not in sentence
    assert sentence.endswith(
        "but there are too few fault-free records to state a false-alarm rate: 200 of 'healthy test';"
        " 299 records of each are needed."
    )


def test_what_is_found_at_an_exceeded_false_alarm_rate_is_said_with_its_reservation():
    sentence = answer_sentence(judged(scores=alarming))
    assert sentence.startswith("With P1 and u, noise finds ")
    assert "but every score exceeds its false-alarm rate (in 'stiffer' and 'much stiffer')" in sentence


def test_what_is_asked_is_said_in_its_own_numbers():
    detection = judged(rules=Rules(false_alarm_rate=0.05, confidence=0.9, probability=0.8))
    said = answer_sentence(detection)
    assert "in 80 % of all cases (90 % confidence) at thresholds set for a false-alarm rate of 5 %" in said


def test_the_smallest_tested_level_is_a_limit():
    def easy(records):
        return [made_up_score(records, "easy", gain=900.0, channels=(P1,))]

    detection = judged(scores=easy)
    assert "easy finds 0.0" in answer_sentence(detection)
    assert "L/min or less nine times" in answer_sentence(detection)
    assert "≤ 0.0" in answer_block(detection).tables[0].rows[0][2].text


def test_equal_sentences_on_many_scores_are_said_once():
    detection = judged(n_healthy=20)
    block = next(block for block in report_of(detection).document().blocks if block.key == "caveats")
    needs = [text for text in block.paragraphs if "needs 99 healthy records" in text]
    assert len(needs) == 2
    assert needs[0].startswith("5 scores (")


def test_a_name_is_no_part_of_the_verdict(detection):
    """Renaming a score changes nothing but its name."""
    judgement = detection.judgements[0]
    renamed = replace(judgement, scored=replace(judgement.scored, name="other"))
    other = replace(detection, judgements=(renamed, *detection.judgements[1:]))
    other = replace(other, pareto=detection.pareto - {judgement.scored.name} | {"other"})
    assert answer_sentence(other) == answer_sentence(detection).replace(judgement.scored.name, "other")


def test_the_answer_names_no_sensors_that_are_not_needed(detection):
    """Of two sets with the same bound the larger one is left out, and a rate above the set one is said."""
    first = detection.judgements[0]
    assert first.scored.name in answer_sentence(detection)
    dominated = replace(detection, pareto=detection.pareto - {first.scored.name})
    assert first.scored.name not in answer_sentence(dominated)
    (population,) = (each for each in first.false_alarms if each.name == "healthy test")
    rate = replace(first.false_alarms[population], low=0.012)
    high = replace(first, false_alarms={**first.false_alarms, population: rate})
    sentence = answer_sentence(replace(detection, judgements=(high, *detection.judgements[1:])))
    assert "more than the 1 % set" in sentence
