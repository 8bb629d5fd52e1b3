"""What could not be stated, and remarks on what is stated."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping

import numpy as np

from hydrofdi.report.document import Block
from hydrofdi.report.wording import capitalized, some
from hydrofdi.settings.counting import counted
from hydrofdi.studies.judgement import Detection

_P_VALUE = re.compile(r" \(p = [^)]*\)")

_MOST = 30
"""Sentences that are printed."""


def caveats_block(detection: Detection) -> Block | None:
    """Remarks on all numbers, then those on single scores; None if there are none.

    Equal sentences on several scores are said once.
    """
    judgements = detection.judgements
    said = [
        *map(_sentence, detection.remarks),
        *_collected((each.scored.name, refusal) for each in judgements for refusal in each.refusals),
        *_collected((each.scored.name, remark) for each in judgements for remark in each.remarks),
        *_collected((each.scored.name, each.scored.note) for each in judgements if each.scored.note),
    ]
    if not said:
        return None
    more = [f"… and {len(said) - _MOST} more; JSON has all."] if len(said) > _MOST else []
    return Block("caveats", "Limitations and remarks", (*said[:_MOST], *more))


def remarks_with_counts(detection: Detection) -> tuple[str, ...]:
    """Remarks on all numbers, then what is not stated or remarked of some scores, with their number.

    A score without any number has only its note.
    """
    n_score = len(detection.judgements)
    notes, others = Counter[str](), Counter[str]()
    for judgement in detection.judgements:
        if np.isfinite(judgement.scored.values).any():
            others.update((*judgement.refusals, *judgement.remarks))
        else:
            notes[judgement.scored.note] += 1
    told = (*notes.most_common(), *others.most_common(_MOST))
    return (
        *detection.remarks,
        *(f"{text} ({n} of {counted(n_score, 'score')})" if n < n_score else text for text, n in told),
    )


def _collected(pairs: Iterable[tuple[str, str]]) -> list[str]:
    said: dict[str, dict[str, str]] = defaultdict(dict)
    for name, sentence in pairs:
        said[_P_VALUE.sub("", sentence)][name] = sentence.rstrip(".")
    return [f"{_of([*own])}: {_common(plain, own)}." for plain, own in said.items()]


def _common(plain: str, said: Mapping[str, str]) -> str:
    """The sentence, without its p-value where that differs."""
    sentences = set(said.values())
    return sentences.pop() if len(sentences) == 1 else plain.rstrip(".")


def _sentence(text: str) -> str:
    return f"{capitalized(text).rstrip('.')}."


def _of(names: list[str]) -> str:
    return f"{counted(len(names), 'score')} ({some(names)})" if len(names) > 1 else names[0]
