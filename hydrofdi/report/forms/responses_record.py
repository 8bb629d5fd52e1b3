"""Varied parameters and responses of features as plain data for JSON."""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrofdi.config.request import parameter_names, parameter_unit
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.responses import AxisResponses, RankCorrelation, Response, ResponseStudy
from hydrofdi.report.responses.study import FIXED, MATCHED
from hydrofdi.report.runs.axes import Axis, Group
from hydrofdi.report.sections.quantiles import QUANTILES

_BASELINES = {FIXED: "fixed", MATCHED: "matched"}


def responses_record(study: ResponseStudy) -> dict[str, Any]:
    """``varied`` and ``responses``; numbers in SI, changes in percent."""
    return {
        "varied": [_varied(found.axis) for found in study.axes],
        "responses": [_response(found, response) for found in study.axes for response in found.responses],
    }


def _varied(axis: Axis) -> dict[str, Any]:
    """A parameter: its values with their runs, or quantiles if there are many values."""
    counts = [int(group.rows.sum()) for group in axis.groups]
    named = {"name": axis.name, "unit": _unit(axis)}
    if not axis.is_in_fifths or axis.numbers is None:
        return {**named, "values": [group.value for group in axis.groups], "n": counts}
    known = axis.numbers[np.isfinite(axis.numbers)]
    quantiles = dict(zip(map(str, QUANTILES), np.quantile(known, QUANTILES).tolist(), strict=True))
    return {**named, "quantiles": quantiles, "n": sum(counts)}


def _unit(axis: Axis) -> str | None:
    """SI unit of a parameter; None for words and plain numbers."""
    return parameter_unit(axis.name) if axis.name in parameter_names() else None


def _response(found: AxisResponses, response: Response) -> dict[str, Any]:
    feature = response.feature
    groups = [
        _ends(found.axis, group)
        | {name: finite(feature.own(getattr(spread, name))) for name in ("median", "low", "high")}
        | {"n": spread.n_run}
        for group, spread in zip(found.axis.groups, response.over, strict=True)
    ]
    return {
        "axis": found.axis.name,
        "baseline": _BASELINES.get(found.against) if feature.is_change else None,
        "feature": feature.name,
        "unit": feature.own_unit,
        "groups": groups,
        "rank_correlation": None if response.rank is None else _rank(response.rank),
    }


def _ends(axis: Axis, group: Group) -> dict[str, Any]:
    """The value of a group, or the smallest and the largest value of a fifth."""
    if not axis.is_in_fifths or axis.numbers is None:
        return {"value": group.value}
    values = axis.numbers[group.rows]
    return {"from": float(np.nanmin(values)), "to": float(np.nanmax(values))}


def _rank(rank: RankCorrelation) -> dict[str, Any]:
    numbers = {name: finite(getattr(rank, name)) for name in ("value", "low", "high", "chance")}
    return {**numbers, "n": rank.n_run}
