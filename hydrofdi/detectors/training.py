"""Training of a detector: from healthy records, window by window, to a detector file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import chain, compress
from typing import Any

import numpy as np

from hydrofdi.detectors import configuration
from hydrofdi.detectors.file import Basis, DetectorFile, Made, TrainedScore
from hydrofdi.detectors.limits import (
    N_PIECE,
    chart_limit,
    chart_of,
    fleet_limits,
    fleet_of,
    limits_of,
    scale_of,
    with_allowance,
)
from hydrofdi.detectors.rules import OF_ONE, ScoreConfig, make_score
from hydrofdi.detectors.scores.contract import cross_fitted_scores, known_numbers, plain_data
from hydrofdi.detectors.scoring import HealthyScores
from hydrofdi.detectors.verdicts import TEMPERATURE, learned_range, standardised
from hydrofdi.errors import DataError, NotStatedError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.balancing import WindowOptions
from hydrofdi.indicators.estimation.whole_record import likeliest_wrong, sentence
from hydrofdi.indicators.faults import CAUSES
from hydrofdi.indicators.measuring import output_unit
from hydrofdi.indicators.nominal_actuator import constants_not_given, sheet_constants
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.recording import found_period
from hydrofdi.settings.messages import time_text


def train(
    healthy: RecordSource,
    config: configuration.DetectorConfig,
    sources: Sequence[str],
    made: Made,
    faulty: RecordSource | None = None,
    fleet: DetectorFile | None = None,
    fleet_name: str = "",
    is_measured: bool = False,
) -> DetectorFile:
    """Train a detector on healthy records.

    Parameters
    ----------
    healthy : RecordSource
        Only healthy records; the groups of their batches identify dependent records. They are read twice if
        windows start with cycles.
    config : DetectorConfig
        Configuration; the file contains it with all defaults.
    sources : sequence of str
        Names of the sources.
    faulty : RecordSource, optional
        Only faulty records, for scores that learn from them too.
    fleet, fleet_name : DetectorFile and str, optional
        Detector of a fleet and its name. Its score is used as it is; with `config` of the same score, its
        summary makes up for healthy windows that are too few.

    is_measured : bool
        Whether a machine was measured: then the limit of a flow allows for warmer oil, if its temperature is
        not known.

    Raises
    ------
    ConfigError
        The indicator has no such output, no direction is stated and the output does not declare one, or
        windows are not valid.
    DataError
        The records lack a channel, or differ in sampling or length, or estimates are physically impossible in
        most windows.
    NotStatedError
        There are too few records for the false-alarm rate; the message states how many are needed.
    """
    window, is_stated = config.window, config.score is not None
    drive = _drive(healthy, window.channel) if window.by == "cycle" else None
    batches = (batch for batch in healthy.batches(labels=True) if batch.n_record)
    first = next(batches, None)
    if first is None:
        raise NotStatedError(f"{healthy.name}: no healthy record")
    if fleet is not None and first.sampling_frequency != fleet.sampling_frequency:
        found_at, wanted = first.sampling_frequency, fleet.sampling_frequency
        raise DataError(f"{healthy.name}: is sampled at {found_at:g} Hz, but {fleet_name} at {wanted:g} Hz")
    stated, sheet = configuration.feature_of(config).indicators.values(), healthy.data_sheet
    taken = {name for each in stated for name in sheet_constants(each.options)}
    config = config if fleet else _with_score(config, first)
    direction, scored = configuration.direction_of(config), HealthyScores(config, first, drive)
    scored.read(chain([first], batches))
    feature, teachers = scored.feature, None
    if faulty is not None and is_stated:
        teachers = HealthyScores(config, first, drive)
        teachers.read(faulty.batches(labels=True))
    trained = _learn(scored, teachers, None if fleet is None else fleet.score)
    _require_scores(scored, healthy.name)
    chart = chart_of(scored, direction)
    others = ""
    try:
        limits = limits_of(scored, direction, has_chart=chart is not None)
        own = scale_of(scored.scores)
        if is_measured and TEMPERATURE not in scored.channels and config.compensate:
            limits, trained = with_allowance(limits, trained, scored)
    except NotStatedError:
        if fleet is None or fleet.fleet is None or config.threshold != "quantile":
            raise
        rate, confidence = config.false_alarm_rate, config.confidence
        limits, own = fleet_limits(scored.scores, fleet.fleet, direction, rate, confidence)
        others = f"{fleet_name}, {fleet.fleet.n_machine} machines"
    spreads, is_two_sided = standardised(scored.scores, own, direction), direction is Direction.BOTH
    used = feature if trained is None else feature.of(trained.numbers)
    fits = {name: [each.possible[1] or 0.0] for name, each in used.outputs.items() if each.is_fit}
    for name, values in fits.items():
        values += [each.fits[name] for each in scored.complete]
        values += [] if fleet is None else [fleet.fits.get(name, values[0])]
    doubts = {(doubt.where, doubt.kind) for each in scored.complete for doubt in each.doubts}
    every = window.every or (scored.duration if window.by == "time" else None)
    window = window.model_copy(update={"duration": scored.duration, "every": every})
    in_full: dict[str, Any] = {"direction": direction, "chart": chart, "window": window}
    if config.score is None:
        in_full["options"] = feature.indicator.options.model_dump(mode="json")
        in_full["output"] = feature.label.removeprefix(f"{config.indicator}.")
    else:
        in_full["indicators"] = configuration.stated_indicators(feature.indicators, in_full=True)
    return DetectorFile(
        made=made,
        config=config.model_copy(update=in_full),
        assumed=tuple(dict.fromkeys(name for each in stated for name in constants_not_given(each.options))),
        data_sheet={name: sheet[name] for name in sheet if name in taken},
        indicator_versions={label: each.version for label, each in used.indicators.items()},
        score=trained,
        unit="1"
        if config.score is not None and config.score.kind not in OF_ONE
        else output_unit(feature.indicator, feature.described, first),
        channels=scored.channels,
        sampling_frequency=first.sampling_frequency,
        n_sample=scored.n_sample,
        basis=_basis(
            scored, sources, found_period(first), np.abs(spreads) if is_two_sided else spreads, others
        ),
        fleet=fleet_of(scored.scores, scored.of_scores),
        healthy=own,
        limits=limits,
        chart=None if chart is None else chart_limit(scored, chart, own, direction),
        ranges={channel: learned_range(channel, facts) for channel, facts in scored.facts.items()},
        conditions=scored.conditions,
        positive=tuple(
            name
            for name, each in used.outputs.items()
            if each.is_positive and (name, "not_positive") not in doubts
        ),
        fits={name: max(values) for name, values in fits.items()},
        drive=drive,
    )


def _with_score(config: configuration.DetectorConfig, first: RecordBatch) -> configuration.DetectorConfig:
    """The same with a second alarm, unless an output is stated: on the flow through all clearances; and with
    the effect of the oil temperature taken out, if that is measured.
    """
    feature = configuration.feature_of(config)
    if config.score is not None or not feature.described.is_score:
        return config
    of, indicators = [feature.label], configuration.stated_indicators(feature.indicators)
    if not config.output and config.direction in (None, Direction.RISING):
        of += [feature.through_all] if feature.through_all in feature.outputs else []
    by = [f"{TEMPERATURE}.mean"] if config.compensate and TEMPERATURE in first.channels else []
    if len(of) + len(by) == 1:
        return config
    if by:
        indicators |= {TEMPERATURE: {"kind": "pressure_statistics", "channel": TEMPERATURE}}
    score = ScoreConfig(kind="either", of=[*of, *by], options={"proxies": len(by)})
    own = {"indicator": "", "options": {}, "output": "", "indicators": indicators, "score": score}
    return config.model_copy(update=own)


def _drive(healthy: RecordSource, channel: Channel) -> tuple[float, float]:
    """Lowest and highest value of the channel whose edges start cycles, over all healthy records."""
    low, high = np.inf, -np.inf
    for batch in healthy.batches(labels=True):
        if batch.n_record and channel in batch.channels:
            low = min(low, float(np.nanmin(batch[channel])))
            high = max(high, float(np.nanmax(batch[channel])))
    if not low < high:
        fault = "is missing in" if high == -np.inf else "never changes in"
        raise NotStatedError(
            f"by=cycle: {channel} {fault} all healthy records, but cycles start at its edges;"
            " choose another channel under 'window:', or use windows by time"
        )
    return low, high


def _learn(
    scored: HealthyScores, teachers: HealthyScores | None, learned: TrainedScore | None
) -> TrainedScore | None:
    """Set the scores of healthy windows: the number itself, the score that a fleet learned, or the
    cross-fitted score of several numbers.
    """
    config, feature = scored.config, scored.feature
    n_healthy, both = len(scored.measured), [scored] if teachers is None else [scored, teachers]
    values = np.array([window.numbers for each in both for window in each.measured])
    if config.score is None or not n_healthy:
        scored.all_scores = values.reshape(-1)
        return None
    if learned is not None:
        kept = [place for place, name in enumerate(feature.numbers) if name in learned.numbers]
        scored.all_scores = learned.fitted(config.score.kind).score(values[:n_healthy, kept])
        return learned
    is_fit = np.array([is_apart for each in both for is_apart in each.is_apart])
    is_faulty = np.arange(len(values)) >= n_healthy
    score = make_score(config.score.kind, config.score.options)
    has_some = np.isfinite(values).any(axis=1)
    kept = known_numbers(values[is_fit & has_some & (score.needs_faulty | ~is_faulty)])
    if config.score.kind in OF_ONE:
        # the number itself may be missing more often
        kept = sorted({0, *kept}) if config.score.kind == "compensated" else [*range(values.shape[1])]
        if not np.isfinite(values[:n_healthy, 0]).any():
            raise _no_score(scored, next(iter(feature.numbers)))
    records = [record for each in both for record in each.records]
    names = [record.group or f"record {index:09d}" for index, record in enumerate(records)]
    groups = [names[index] for index in scored.record]
    if teachers is not None:
        groups += [names[len(scored.records) + index] for index in teachers.record]
    if len(set(groups)) == 1:
        groups = [f"piece {N_PIECE * place // n_healthy}" for place in range(n_healthy)]
    used = np.ascontiguousarray(values[:, kept])
    scored.all_scores = cross_fitted_scores(score, used, is_faulty, groups, is_fit=is_fit)[:n_healthy]
    fitted = score.fit(used[is_fit], is_faulty[is_fit])
    return TrainedScore(
        numbers=tuple(name for place, name in enumerate(feature.numbers) if place in kept),
        rule=plain_data(fitted.rule),
        n_healthy=fitted.n_healthy,
        n_faulty=fitted.n_faulty,
    )


def _no_score(scored: HealthyScores, label: str) -> NotStatedError:
    longest = time_text(max(record.duration for record in scored.records))
    absent = f"no window ends within its records, of which the longest lasts {longest}"
    reasons = Counter(fault.message for fault in scored.faults)
    reason = next((text for text, _ in reasons.most_common(1)), absent)
    return NotStatedError(f"no healthy record has {label}: {reason}")


def _require_scores(scored: HealthyScores, name: str) -> None:
    """Check that there are scores, and that estimates are possible in at least half of the windows."""
    if not scored.scores.size:
        raise _no_score(scored, scored.feature.label)
    if 2 * len(scored.refused) > scored.scores.size and not scored.config.accept:
        outputs = " and ".join(sorted({each.where for each in scored.refused}))
        likely = f"{_likely(scored)}; ".removeprefix("; ")
        raise DataError(
            f"{name}: {outputs}: beyond what the described actuator allows in {len(scored.refused):,} of"
            f" {scored.scores.size:,} healthy windows: {CAUSES} {likely}--accept trains anyway"
        )


def _likely(scored: HealthyScores) -> str:
    """The constants of the data sheet that are likeliest wrong, if it does not fit most windows."""
    of_balance = (each.options for each in scored.feature.indicators.values())
    options = next((each for each in of_balance if isinstance(each, WindowOptions)), None)
    unfit = [scored.n_impossible[name] for name, each in scored.feature.outputs.items() if each.is_fit]
    if options is None or Channel.PISTON_POSITION not in scored.channels:
        return ""
    if 2 * max(len(scored.refused), *unfit) <= scored.scores.size:
        return ""
    return sentence(options, likeliest_wrong(options, scored.first))


_OUTLYING = 8.0
"""Healthy spreads from the median beyond which a record with most of its windows is said to be unlike the
others; a choice."""


def _basis(
    scored: HealthyScores, sources: Sequence[str], drive_period: float | None, spreads: Array, fleet: str
) -> Basis:
    """The data behind a detector; `spreads`: used scores in healthy spreads, rising with a leak."""
    used = np.array(scored.record, dtype=np.intp)[scored.is_used].tolist()
    populations = Counter(scored.records[index].label for index in used)
    del populations[""]
    windows, far = Counter(used), Counter(compress(used, spreads > _OUTLYING))
    return Basis(
        sources=tuple(sources),
        n_record=len(scored.records),
        n_window=scored.scores.size,
        n_group=len(set(scored.groups)) if scored.has_groups else 0,
        populations=dict(sorted(populations.items())),
        not_judged=dict(sorted(Counter(fault.kind for fault in scored.faults).items())),
        impossible=dict(sorted(scored.n_impossible.items())),
        likely=_likely(scored),
        fleet=fleet,
        outlying={scored.records[index].name: n for index, n in far.items() if 2 * n > windows[index]},
        drive_period=drive_period,
    )
