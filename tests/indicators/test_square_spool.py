"""``spool: square`` and its amplitude are options where they do something, and nowhere else."""

import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import indicator_names, make_indicators
from hydrofdi.indicators.registry import indicator_kind

WITH_SPOOL = [name for name in indicator_names() if "spool" in indicator_kind(name).Options.model_fields]


@pytest.mark.parametrize("name", WITH_SPOOL)
def test_an_amplitude_is_an_option_where_a_square_wave_is(name):
    takes_square = True
    try:
        make_indicators({name: {"spool": "square"}})
    except ConfigError:
        takes_square = False
    assert ("drive_amplitude" in indicator_kind(name).Options.model_fields) == takes_square
