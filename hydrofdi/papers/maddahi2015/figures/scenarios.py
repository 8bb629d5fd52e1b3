"""The scenarios study: how often the claims hold, and by which values."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from hydrofdi.config.shown_values import ShownParameter, shown_parameter
from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.scenarios.study import ScenarioStudy
from hydrofdi.papers.maddahi2015.scenarios.values import ValueShare
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures.style import BLUE, INK, ORANGE, RULE


def draw_scenarios(study: Study) -> Figure:
    """Share of the feasible scenarios that reproduce each claim, and C1–C4 by parameter value."""
    scenarios = study.scenarios
    if scenarios is None:
        raise ReportError("the experiment has no ensemble")
    if not scenarios.feasible.any():
        raise ReportError("no scenario is feasible")
    n_bar, n_value = len(scenarios.claim_sets), len(scenarios.value_shares) + len(_groups(scenarios))
    heights = [n_bar * 0.24 + 0.6, n_value * 0.2 + 0.6]
    figure = Figure(figsize=(7.4, sum(heights) + 0.6), layout="constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=heights)
    _draw_claims(top, scenarios)
    _draw_values(bottom, scenarios)
    handles, labels = bottom.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _draw_claims(axis: Any, study: ScenarioStudy) -> None:
    total = int(study.feasible.sum())
    names = list(study.claim_sets)
    counts = [int(study.reproducing(claims).sum()) for claims in study.claim_sets.values()]
    texts = [
        "open" if study.is_open(claims) else f"{count:,}"
        for claims, count in zip(study.claim_sets.values(), counts, strict=True)
    ]
    colors = [BLUE if len(claims) == 1 else ORANGE for claims in study.claim_sets.values()]
    bars = axis.barh(range(len(names)), [100.0 * count / total for count in counts], color=colors, height=0.7)
    axis.bar_label(bars, texts, padding=3, fontsize=8, color=INK)
    axis.set_yticks(range(len(names)), names)
    axis.invert_yaxis()
    axis.set_xlim(0.0, 109.0)
    axis.grid(visible=False, axis="y")
    axis.set_title(f"scenarios that reproduce the claims, of {total:,} feasible ones")
    axis.set_xlabel("share of the feasible scenarios [%]")


def _groups(study: ScenarioStudy) -> list[tuple[str, ...]]:
    return list(dict.fromkeys(value.parameters for value in study.value_shares))


def _draw_values(axis: Any, study: ScenarioStudy) -> None:
    series = {
        "C1–C4": {"color": ORANGE, "marker": "o", "markersize": 7.5},
        "C1–C6": {"color": BLUE, "marker": "D", "markersize": 4.0},
    }
    heights, labels = _layout(study)
    for name, style in series.items():
        claims = study.claim_sets[name]
        if study.is_open(claims):
            continue
        mask, decided = study.reproducing(claims), study.decided(claims)
        shares = []
        for value in study.value_shares:
            total = int((value.members & decided).sum())
            shares.append(100.0 * int((value.members & mask).sum()) / total if total else float("nan"))
        overall = 100.0 * mask.sum() / decided.sum()
        axis.axvline(overall, color=style["color"], linewidth=0.8, linestyle=":")
        axis.plot(shares, heights, linestyle="none", clip_on=False, label=name, **style)
    axis.set_yticks(list(labels), list(labels.values()), fontsize=7.5)
    axis.invert_yaxis()
    axis.grid(color=RULE, axis="y")
    axis.set_title("the same by parameter value; dotted: over all")
    axis.set_xlabel("share of the feasible scenarios with this value [%]")
    axis.set_xlim(left=0.0)


def _layout(study: ScenarioStudy) -> tuple[list[float], dict[float, str]]:
    """Height of each value, and what stands at the heights, parameters above their values."""
    heights: list[float] = []
    labels: dict[float, str] = {}
    height, previous = -1.0, None
    shown = {names: _shown(study, names) for names in _groups(study)}
    for value in study.value_shares:
        height += 1.0
        if value.parameters != previous:
            labels[height] = ", ".join(each.header for each in shown[value.parameters])
            height, previous = height + 1.0, value.parameters
        heights.append(height)
        labels[height] = _value_text(value, shown[value.parameters])
    return heights, labels


def _shown(study: ScenarioStudy, names: tuple[str, ...]) -> list[ShownParameter]:
    """The parameters that vary together, each in the unit that suits all its values."""
    of_names = [value.values for value in study.value_shares if value.parameters == names]
    if len(names) == 1:
        return [shown_parameter(names[0], [end for values in of_names for end in values])]
    return [
        shown_parameter(name, values) for name, values in zip(names, zip(*of_names, strict=True), strict=True)
    ]


def _value_text(value: ValueShare, shown: list[ShownParameter]) -> str:
    if value.is_range:
        return " … ".join(shown[0].text(end) for end in value.values)
    return ", ".join(each.text(part) for each, part in zip(shown, value.values, strict=True))
