"""Several files of indicators where one is expected."""

import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import load_indicators


@pytest.mark.parametrize("given", ["a.yaml,b.yaml", "dwt,b.yml", "a.yaml, dwt"])
def test_several_files_are_refused_with_the_way_out(given):
    with pytest.raises(ConfigError, match="give one file; its 'indicators:' may contain several labels"):
        load_indicators(given)
