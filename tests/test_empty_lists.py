"""Lists that need entries."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError


def test_an_empty_list_is_refused_in_plain_words():
    online = "{false_alarm_every: [], charts: {a: {of: weak_rls.leakage, chart: cusum}}}"
    with pytest.raises(ConfigError, match="needs 1 entry or more; found 0"):
        load_experiment(None, [f"detection.online={online}"])
