"""Control charts on the time series of a score.

The input of a chart are standardised scores (median 0 and spread 1 if healthy); it does not depend on their
interval or on the indicator. It raises an alarm when its statistic reaches the limit.
"""
