"""Cautions shared by scores with the same kind of training."""

FROM_HEALTHY = (
    "It is trained on healthy records only: any condition that is not in the fit records, such as"
    " stiffer oil or another machine, raises it like a leak. Its own fit records have too low scores:"
    " set thresholds on other healthy records, or on cross-fitted scores."
)

FROM_BOTH = (
    "It applies to the population that it was fitted on: if healthy plants vary in other ways, many may"
    " raise alarms. Fit it on records in which everything varies that varies on the machine, and check its"
    " false alarms on shifts and confusions. Set thresholds on healthy records that it was not fitted on,"
    " or on cross-fitted scores, and test no record of the fit."
)
