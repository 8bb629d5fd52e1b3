"""Suggestions for unknown names."""

import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators


def test_a_channel_is_found_by_its_words_in_another_order() -> None:
    with pytest.raises(ConfigError, match="did you mean 'chamber_1_pressure'"):
        make_indicators({"dwt": {"channel": "pressure_1"}})
