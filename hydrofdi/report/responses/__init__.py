"""Responses of each feature to the values of each varied parameter.

`study_responses` makes a `ResponseStudy`, which `Analysis.responses` holds: for each axis an `AxisResponses`
with one `Response` per feature, which has median, low and high for each group of runs on that axis.
"""

from hydrofdi.report.responses.features import Feature
from hydrofdi.report.responses.rank import RankCorrelation, rank_correlation
from hydrofdi.report.responses.study import AxisResponses, Response, ResponseStudy, Spread, study_responses

__all__ = [
    "AxisResponses",
    "Feature",
    "RankCorrelation",
    "Response",
    "ResponseStudy",
    "Spread",
    "rank_correlation",
    "study_responses",
]
