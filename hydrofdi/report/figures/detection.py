"""Figures of a judged study: what is found, the scores of each population, alarms, curves, and delays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import NotStatedError, ReportError
from hydrofdi.evaluation.pod import DetectableSeverity
from hydrofdi.evaluation.rates import roc_curve
from hydrofdi.evaluation.scores import Array, Kind, Population
from hydrofdi.report import figures as look
from hydrofdi.report.detection import wording
from hydrofdi.report.detection.wording import SeverityUnit, chosen_levels, sensors, severity_unit, tested
from hydrofdi.report.document import FigureKind
from hydrofdi.settings.messages import convert, readable_unit, typeset
from hydrofdi.studies.judging import reference_of
from hydrofdi.studies.records import SOUND, ChartJudgement, Detection, Judgement, part
from hydrofdi.tables.table import folded

_MOST, _MOST_LEVELS, _MOST_RANKED, _MOST_SETS, _LETTERS = 6, 7, 24, 10, 115
"""Scores with a panel, leaking populations beside the others, ranked scores, sets of sensors of the answer,
and letters of a line below these."""

_N_BIN, _WIDEST = 50, 4.0
"""Bins, and how far beyond the healthy scores they reach, in widths of these."""

_COLORS = dict(zip((*SOUND, Kind.FAULT), (look.BLUE, look.GREEN, look.PINK, look.ORANGE), strict=True))


def _marks(detection: Detection, shown: Sequence[Judgement]) -> dict[str, dict[str, Any]]:
    """Sets of sensors of the shown scores → colour and marker, which are the same in all figures.

    The largest set of the study comes first; all beyond seven have the last mark.
    """
    sizes = {sensors(judgement): len(judgement.scored.channels) for judgement in detection.judgements}
    ordered = sorted(sizes, key=lambda name: (-sizes[name], name))
    last = len(look.COLORS) - 1
    return {
        name: {"color": look.COLORS[min(index, last)], "marker": look.MARKERS[min(index, last)]}
        for index, name in enumerate(ordered)
        if name in {sensors(each) for each in shown}
    }


def draw_answer(detection: Detection) -> Figure:
    """A row for each set of sensors that finds more than its parts, and for the best wavelet rule."""
    if not (able := wording.answers(detection)):
        raise ReportError("no score is shown to find a leak at the false-alarm rate that is set")
    compared = [each for each in wording.wavelet_rules(detection) if each.bound is not None][:1]
    shown, unit = [*dict.fromkeys((*able[:_MOST_SETS], *compared))], severity_unit(detection)
    labels = [f"{', '.join(wording.symbols(each))}\n{_bracketed(each)}".strip() for each in shown]
    figure = _draw_rows(detection, shown, labels, 0.5)
    offset: dict[str, Any] = {"xytext": (9, 0), "textcoords": "offset points", "va": "center"}
    for row, bound in enumerate(each.bound for each in shown):
        if bound is not None:
            text = unit.found(bound).removesuffix(wording.FROM_LEVELS)
            figure.axes[0].annotate(f"{text} {unit.name}".rstrip(), (_reached(bound, unit), row), **offset)
    low, high = figure.axes[0].get_xlim()
    figure.axes[0].set_xlim(low, 1.5 * high)
    alarms = wording.false_alarms_in_words(detection.rules.false_alarm_rate)
    often = wording.probability_in_words(detection.rules.probability)
    title = f"The smallest {unit.quantity} that is found {often}, at {alarms}"
    figure.suptitle(title, x=0.01, ha="left", fontsize=12)
    return figure


def draw_ranking(detection: Detection) -> Figure:
    """q90 and q90/95 of the foremost scores, coloured by their sensors."""
    shown = [each for each in wording.foremost(detection, _MOST_RANKED) if each.smallest]
    if not shown:
        raise ReportError("no score has a severity that can be stated")
    figure = _draw_rows(detection, shown, [*map(_bracketed, shown)], 0.26)
    marks = _marks(detection, shown)
    points = {name: {**mark, "linestyle": "none", "markersize": 5.5} for name, mark in marks.items()}
    look.legend_outside(figure, points, min(len(points), 5), "sensors")
    if len(shown) < len(detection.judgements):
        figure.axes[0].set_title(f"the foremost {len(shown)} of {len(detection.judgements):,} scores")
    return figure


def _draw_rows(
    detection: Detection, shown: Sequence[Judgement], labels: Sequence[str], height: float
) -> Figure:
    """A row for each score, from its estimate to its bound; an arrow where the bound is not within."""
    marks, unit = _marks(detection, shown), severity_unit(detection)
    figure = Figure(figsize=(8.0, 1.6 + height * len(shown)), layout="constrained")
    axis = figure.subplots()
    for row, judgement in enumerate(shown):
        mark = marks[sensors(judgement)]
        bound, estimate = judgement.bound, judgement.smallest.get("q90")
        values = (each.value for each in (estimate, bound) if each is not None)
        ends = [unit.value(value) for value in values if value is not None]
        if len(ends) == 2:
            axis.plot(ends, [row, row], color=mark["color"], linewidth=1.2)
        style = {**mark, "markersize": 5.5, "linestyle": "none"}
        if estimate is not None and estimate.place == "within":
            axis.plot(unit.value(estimate.severity), row, **style, markerfacecolor=look.PAPER)
            estimate = None
        if (end := bound or estimate) is not None:
            arrow = {"below": r"$\leftarrow$", "above": r"$\rightarrow$"}.get(end.place)
            style |= {"marker": arrow, "markersize": 11} if arrow else {}
            axis.plot(_reached(end, unit), row, **style)
    look.log_axis(axis.xaxis)
    look.row_axis(axis, labels)
    share = f"{100.0 * detection.rules.probability:g} %"
    axis.set_xlabel(f"{unit.quantity} found with {share} probability{unit.bracket}")
    figure.supxlabel(_note(detection, shown), x=0.01, ha="left", fontsize=8)
    return figure


def _bracketed(judgement: Judgement) -> str:
    return f"({judgement.name})" if judgement.keeps_its_rate is False else judgement.name


def _reached(bound: DetectableSeverity, unit: SeverityUnit) -> float:
    """Where a bound stands on the axis."""
    return unit.value(min(bound.severity, unit.largest) if bound.place == "above" else bound.severity)


def _note(detection: Detection, shown: Sequence[Judgement]) -> str:
    """What the marks mean, those that occur."""
    sides = {bound.place for each in shown for bound in each.smallest.values()}
    parts = {
        "open: estimate": True,
        f"filled: bound with {100.0 * detection.rules.confidence:g} % confidence": True,
        "← at most the smallest tested": "below" in sides,
        "→ not found up to the largest tested": "above" in sides,
        "(in brackets): exceeds its false-alarm rate": any(each.keeps_its_rate is False for each in shown),
    }
    return fill("; ".join(text for text, occurs in parts.items() if occurs), _LETTERS)


def _foremost(detection: Detection) -> tuple[Judgement, ...]:
    """The foremost scores that have a threshold."""
    shown = tuple(each for each in wording.foremost(detection, _MOST) if each.threshold is not None)
    if not shown:
        raise ReportError("no score has a threshold")
    return shown


def _named(judgement: Judgement) -> str:
    """Name and sensors, which are not parted."""
    name, needs = judgement.name, f"({sensors(judgement)})"
    return name if needs in name else f"{name} " + needs.replace(" ", "\N{NO-BREAK SPACE}")


def _score_panels(shown: Sequence[Judgement], height: float, **more: Any) -> tuple[Any, list[Any]]:
    """A figure with a panel for each score."""
    figure, axes = look.panels(len(shown), 3, width=3.0, height=height, sharey=True, **more)
    for axis, judgement in zip(axes, shown, strict=True):
        axis.set_title("\n".join(folded(_named(judgement), 32)), fontsize=8.5)
    return figure, axes


def draw_densities(detection: Detection) -> Any:
    """A ridge for each population, a panel for each of the foremost scores."""
    shown = wording.foremost(detection, _MOST)
    if not shown:
        raise ReportError("no indicator could measure any record")
    chosen = chosen_levels(detection, _MOST_LEVELS)
    populations = [each for each in detection.records.populations if each.kind in SOUND or each in chosen]
    figure, axes = _score_panels(shown, 0.9 + 0.28 * len(populations))
    for axis, judgement in zip(axes, shown, strict=True):
        _draw_densities(axis, detection, judgement, populations)
    labels = [f"{each.name} (fit)" if each.is_fit and "fit" not in each.name else each.name
              for each in populations]  # fmt: skip
    axes[0].set_yticks(range(len(populations)), labels, fontsize=8)
    axes[0].set_ylim(len(populations) - 0.8, -1.1)
    return figure


def _draw_densities(
    axis: Any, detection: Detection, judgement: Judgement, populations: Sequence[Population]
) -> None:
    scores = [judgement.scored.values[detection.records.rows(population)] for population in populations]
    scores = [own[np.isfinite(own)] for own in scores]
    healthy = [own for own, each in zip(scores, populations, strict=True) if each.kind is Kind.HEALTHY]
    ends = () if judgement.threshold is None else (judgement.threshold.low, judgement.threshold.high)
    limits = [end for end in ends if np.isfinite(end)]
    edges = _edges(np.concatenate([limits, *healthy]), np.concatenate(scores))
    unit = readable_unit(judgement.scored.unit, float(np.abs(edges).max()))
    scale = convert(1.0, unit, judgement.scored.unit)
    for row, (population, own) in enumerate(zip(populations, scores, strict=True)):
        # Scores beyond either end stand in the last bin there.
        counts, _ = np.histogram(np.clip(own, edges[0], edges[-1]), edges)
        if counts.any():
            ridge, color = row - 0.95 * counts / counts.max(), _COLORS[population.kind]
            axis.stairs(ridge, edges * scale, baseline=row, fill=True, color=color, alpha=0.35)
            axis.stairs(ridge, edges * scale, baseline=row, color=color, linewidth=0.7)
    for limit in limits:
        axis.axvline(limit * scale, color=look.INK, linewidth=0.9)
    axis.set_xlim(edges[0] * scale, edges[-1] * scale)
    axis.set_xlabel("score" if unit == "1" else f"score [{typeset(unit)}]", fontsize=8)
    axis.locator_params(axis="x", nbins=4)
    axis.ticklabel_format(axis="x", useOffset=False)


def _edges(healthy: Array, scores: Array) -> Array:
    """Edges of the bins: all scores, if the healthy ones remain visible."""
    if not healthy.size:
        return np.linspace(0.0, 1.0, _N_BIN + 1)
    low, high = healthy.min(), healthy.max()
    reach = _WIDEST * (high - low) or max(abs(high), 1.0)
    low, high = max(scores.min(initial=low), low - reach), min(scores.max(initial=high), high + reach)
    margin = 0.03 * (high - low) or 0.5 * reach
    return np.linspace(low - margin, high + margin, _N_BIN + 1)


def draw_false_alarms(detection: Detection) -> Any:
    """Rates of healthy test records, shifts and confusions, a panel for each of the foremost scores."""
    shown, populations = _foremost(detection), tested(detection, *SOUND)
    if not populations:
        raise ReportError("no record with a healthy seal is tested")
    marks, asked = _marks(detection, shown), 100.0 * detection.rules.false_alarm_rate
    height = 0.8 + 0.24 * len(populations)
    figure, axes = _score_panels(shown, height, sharex=True, x="records that raise an alarm [%]")
    rates = [rate for each in shown for one, rate in each.false_alarms.items() if one in populations]
    highest = max([2.0 * asked, *(100.0 * rate.high for rate in rates if rate.total)])
    for axis, judgement in zip(axes, shown, strict=True):
        look.percent_axis(axis, highest)
        mark = marks[sensors(judgement)]
        for row, population in enumerate(populations):
            outcome = judgement.of(population)
            if outcome is not None and (rate := outcome.found) is not None and rate.total:
                face = {"markerfacecolor": look.PAPER} if outcome.is_counted else {}
                ends = [100.0 * rate.low, 100.0 * rate.high]
                axis.plot(ends, [row, row], color=mark["color"], linewidth=1.2)
                style = {**mark, **face, "markersize": 5, "linestyle": "none", "clip_on": False}
                axis.plot(100.0 * rate.value, row, **style)
        axis.axvline(asked, color=look.INK, linewidth=0.9)
    look.row_axis(axes[0], [population.name for population in populations])
    return figure


_LEAST = 0.001
"""Smallest rate on the axes."""


def draw_roc(detection: Detection) -> Any:
    """Detections against false alarms: a panel for each of some severities, a line for each score."""
    shown, levels = _foremost(detection), chosen_levels(detection, 3)
    if not levels:
        raise ReportError("no faulty record is tested")
    unit, marks = severity_unit(detection), _marks(detection, shown)
    styles = {
        _named(each): {**look.series(index), "color": marks[sensors(each)]["color"]}
        for index, each in enumerate(shown)
    }
    labels = {"x": "false alarms [%]", "y": "detections [%]"}
    figure, axes = look.panels(len(levels), 3, width=3.0, height=3.0, sharex=True, sharey=True, **labels)
    for axis, level in zip(axes, levels, strict=True):
        for judgement, style in zip(shown, styles.values(), strict=True):
            if (curve := _curve(detection, judgement, level)) is not None:
                axis.plot(*curve, **style)
                stated, rates = judgement.of(level), judgement.false_alarms
                healthy = [rate for each, rate in rates.items() if each.kind is Kind.HEALTHY]
                if healthy and stated is not None and stated.found is not None and stated.found.total:
                    point = np.clip([healthy[0].value, stated.found.value], _LEAST, 1.0 - _LEAST)
                    axis.plot(*point, marker="o", markersize=4, color=style["color"], clip_on=False)
        axis.set_title(unit.text(level.severity) if level.severity else level.name)
        look.logit_axis(axis.xaxis, _LEAST)
        look.logit_axis(axis.yaxis, _LEAST)
        if axis.lines:  # chance, and the rate that thresholds are set for
            ends = [_LEAST, 1.0 - _LEAST]
            axis.plot(ends, ends, color=look.INK, linewidth=0.6, linestyle="--")
            axis.axvline(detection.rules.false_alarm_rate, color=look.INK, linewidth=0.7)
    look.legend_outside(figure, styles, 2)
    return figure


def _curve(detection: Detection, judgement: Judgement, level: Population) -> tuple[Array, Array] | None:
    records, scored = detection.records, judgement.scored
    _, healthy, of = reference_of(records, scored, judgement.direction)
    try:
        return None if healthy is None else roc_curve(healthy, of(part(records, scored, [level]).scores))
    except NotStatedError:
        return None


_POINTS = 201
"""Points of a curve."""


def draw_pod(detection: Detection) -> Any:
    """Levels and curve of each, a panel each."""
    shown = [each for each in _foremost(detection) if any(level.found for level in each.levels)]
    if not shown:
        raise ReportError("no faulty record is tested")
    marks, unit = _marks(detection, shown), severity_unit(detection)
    labels = {"x": f"{unit.quantity}{unit.bracket}", "y": "records detected [%]"}
    figure, axes = _score_panels(shown, 2.5, sharex=True, **labels)
    for axis, judgement in zip(axes, shown, strict=True):
        _draw_levels(axis, judgement, unit, marks[sensors(judgement)])
        axis.axhline(100.0 * detection.rules.false_alarm_rate, color=look.INK, linewidth=0.7, linestyle=":")
        axis.axhline(100.0 * detection.rules.probability, color=look.INK, linewidth=0.5)
        look.log_axis(axis.xaxis)
    axes[0].set_ylim(-3.0, 103.0)
    return figure


def _draw_levels(axis: Any, judgement: Judgement, unit: SeverityUnit, mark: dict[str, Any]) -> None:
    """Rates of the levels with their bound, and the curve where q90 is taken from it."""
    color, estimate = mark["color"], judgement.smallest.get("q90")
    curve = next(iter(judgement.bounding), judgement.curve)
    if curve is not None and estimate and estimate.source != "levels" and curve.tally.severity.size > 1:
        severities = np.geomspace(*curve.tally.span, _POINTS)
        shares = 100.0 * curve.probability(severities)
        axis.plot([*map(unit.value, severities.tolist())], shares, color=color)
    for level in judgement.levels:
        rate = level.found
        if rate is not None and rate.total:
            severity = unit.value(level.severity if level.severity > 0.0 else level.population.severity)
            spread = [[100.0 * (rate.value - rate.low)], [100.0 * (rate.high - rate.value)]]
            style = {"fmt": mark["marker"], "markersize": 3.5, "elinewidth": 0.7, "color": color}
            axis.errorbar(severity, 100.0 * rate.value, spread, **style)
    if judgement.bound is not None and judgement.bound.value is not None:
        axis.axvline(unit.value(judgement.bound.value), color=color, linewidth=1.2)


def draw_delays(detection: Detection) -> Any:
    """A panel for each leak, a line for each chart."""
    levels = list(dict.fromkeys(level for chart in detection.charts for level in chart.delays))
    if not levels:
        raise ReportError("no leak sets in while a chart watches")
    labels = list(dict.fromkeys(chart.label for chart in detection.charts))
    styles = {
        label: {**look.series(k), "marker": look.MARKERS[k % len(look.MARKERS)], "markersize": 3.5}
        for k, label in enumerate(labels)
    }
    names = {"x": "mean time between false alarms that is asked for [h]", "y": "median delay [s]"}
    figure, axes = look.panels(len(levels), 4, width=2.6, height=2.6, sharex=True, sharey=True, **names)
    unit = severity_unit(detection)
    every = [convert(chart.false_alarm_every, "h") for chart in detection.charts]
    for axis, level in zip(axes, levels, strict=True):
        for label, style in styles.items():
            charts = [chart for chart in detection.charts if chart.label == label and level in chart.delays]
            _draw_line(axis, charts, level, detection.rules.confidence, style)
        axis.set_title(unit.text(level.severity))
        axis.set_xlim(min(every) / 1.5, max(every) * 1.5)
        look.log_axis(axis.xaxis)
    axes[0].set_ylim(bottom=0.0)
    look.legend_outside(figure, styles, 4)
    return figure


def _draw_line(
    axis: Any, charts: Sequence[ChartJudgement], level: Population, confidence: float, style: dict[str, Any]
) -> None:
    """Delays of a leak over the time between false alarms, ascending."""
    known = []
    for chart in charts:
        delays = chart.delays[level]
        median = delays.quantile(0.5, confidence=confidence)
        if np.isfinite(median.value):
            ends = median.low, min(median.high, delays.watched)
            known.append((convert(chart.false_alarm_every, "h"), median.value, *ends))
    every, medians, low, high = np.array(sorted(known)).reshape(-1, 4).T
    axis.plot(every, medians, **style)
    axis.fill_between(every, low, high, color=style["color"], alpha=0.18, linewidth=0)


_FIGURES: dict[str, tuple[Callable[[Detection], Any], str]] = {
    "ranking": (draw_ranking, "The smallest severity that each score finds: estimates and bounds"),
    "pod": (
        draw_pod,
        "Share of records detected over their severity, with intervals, and the fitted curve; vertical:"
        " q90/95; dotted: the false-alarm rate of the threshold",
    ),
    "roc": (draw_roc, "Detections against false alarms over all thresholds; dots: the threshold in use"),
    "false_alarms": (
        draw_false_alarms,
        "Alarms of records whose seal is sound, with intervals; open: too few records",
    ),
    "densities": (draw_densities, "Scores of each population; vertical lines: thresholds"),
    "answer": (draw_answer, "The smallest severity that is found with each set of sensors"),
    "delays": (
        draw_delays,
        "Median delay from the onset of a leak to the alarm, over the time between false alarms",
    ),
}


def detection_figures(detection: Detection) -> dict[str, FigureKind]:
    """The figures of a judged study, and of its charts."""
    is_there = {"answer": bool(wording.answers(detection)), "delays": bool(detection.charts)}
    return {
        name: FigureKind(caption, partial(draw, detection))
        for name, (draw, caption) in _FIGURES.items()
        if is_there.get(name, True)
    }
