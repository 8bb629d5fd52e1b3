"""Options that no memory or patience is enough for."""

import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators


@pytest.mark.parametrize(("name", "option", "largest"), [
    ("ekf_joint", "substeps", 100),
    ("ekf_innovation", "substeps", 100),
    ("ukf_joint", "substeps", 100),
    ("weak_rls", "half_window", 100_000),
    ("flow_balance", "half_window", 100_000),
    ("pressure_balance", "half_window", 100_000),
])  # fmt: skip
def test_what_would_never_end_is_refused(name, option, largest):
    assert make_indicators({name: {option: largest}})
    with pytest.raises(ConfigError, match="must be at most"):
        make_indicators({name: {option: largest + 1}})
