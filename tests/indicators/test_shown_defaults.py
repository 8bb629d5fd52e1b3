"""Defaults of options are listed in units that a person reads, and a configuration may state them so."""

from __future__ import annotations

import pytest

from hydrofdi.indicators import indicator_names
from hydrofdi.indicators.description import describe
from hydrofdi.indicators.registry import indicator_kind
from hydrofdi.units import parse_quantity

BUILT_IN = [name for name in indicator_names() if indicator_kind(name).__module__.startswith("hydrofdi.")]


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_listed_default_is_the_default(name) -> None:
    kind = indicator_kind(name)
    for option in describe(name).options:
        value = kind.Options.model_fields[option.name].get_default(call_default_factory=True)
        if isinstance(value, float) and option.unit not in ("", "1"):
            assert parse_quantity(option.default, option.unit) == pytest.approx(value, rel=1e-12, abs=0)
