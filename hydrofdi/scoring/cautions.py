"""What has to be known of every score that learns in the same way."""

FROM_HEALTHY = (
    "It knows what is healthy, not what a leak looks like: whatever the fit records did not show, such as"
    " stiffer oil or another machine, raises it as a leak does. Records that it was fitted on score too low:"
    " set thresholds on other healthy records, or on cross-fitted scores."
)

FROM_BOTH = (
    "It knows the population that it was fitted on: where healthy plants vary in other ways, many of them may"
    " raise alarms. Fit it where everything varies that varies at the machine, and look at its false alarms"
    " on shifts and confusions. Set thresholds on healthy records that it was not fitted on, or on"
    " cross-fitted scores, and test no record of the fit."
)
