"""Errors of points whose values do not fit each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from hydrofdi.config.request import RunRequest
from hydrofdi.config.shown_values import shown_values
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import describe_error

_MOST_NAMED = 4


def impossible_point(
    nominal: RunRequest, values: Mapping[str, Any], error: ValueError, key: str, where: str = ""
) -> ConfigError:
    """The error of a point that is impossible, with the values that make it so.

    Parameters
    ----------
    nominal : RunRequest
        What the point changes.
    values : mapping
        Dotted parameter → value in SI.
    error : ValueError
        What is wrong.
    key : str
        Key of the file that asks for the point.
    where : str
        What the point belongs to, such as a population.
    """
    reason = describe_error(error.errors()[0]) if isinstance(error, ValidationError) else error
    blamed = {name: values[name] for name in _blamed(nominal, values) or values}
    named = dict(list(blamed.items())[:_MOST_NAMED])
    more = f" and {len(blamed) - len(named)} more" if len(blamed) > len(named) else ""
    place = f"in {where}, " if where else ""
    return ConfigError([Issue(f"{place}at {shown_values(named)}{more}: {reason}", key)])


def _blamed(nominal: RunRequest, values: Mapping[str, Any]) -> list[str]:
    """The parameters each of which makes the point possible by keeping its nominal value."""
    return [
        name
        for name in values
        if _is_possible(nominal, {other: value for other, value in values.items() if other != name})
    ]


def _is_possible(nominal: RunRequest, values: Mapping[str, Any]) -> bool:
    try:
        nominal.with_values(values)
    except ValueError:
        return False
    return True
