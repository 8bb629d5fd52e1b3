"""Calls of public functions whose arguments do not fit, refused in one sentence."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from typing import Any, ParamSpec, TypeVar

from hydrofdi.errors import ConfigError
from hydrofdi.settings.suggestions import listed, similar

Given = ParamSpec("Given")
Returned = TypeVar("Returned")


def bound(function: Callable[Given, Returned]) -> Callable[Given, Returned]:
    """The same function or method; arguments that are unknown, missing or too many raise a `ConfigError`."""
    accepted = signature(function)

    @wraps(function)
    def call(*args: Given.args, **kwargs: Given.kwargs) -> Returned:
        try:
            accepted.bind(*args, **kwargs)
        except TypeError:
            raise ConfigError(f"{function.__name__}: {_misfit(accepted.parameters, args, kwargs)}") from None
        return function(*args, **kwargs)

    return call


def _misfit(parameters: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> str:
    """What is wrong with arguments that do not fit."""
    if own := parameters.keys() & {"self", "cls"}:
        parameters, args = {name: each for name, each in parameters.items() if name not in own}, args[1:]
    single = {name: each for name, each in parameters.items() if each.kind is not Parameter.VAR_KEYWORD}
    by_place = [name for name, each in single.items() if each.kind is not Parameter.KEYWORD_ONLY]
    by_name = [name for name, each in single.items() if each.kind is not Parameter.POSITIONAL_ONLY]
    if len(single) == len(parameters) and (unknown := [name for name in kwargs if name not in by_name]):
        hint = similar(unknown[0], by_name) or listed(by_name) or "; it takes no arguments"
        return f"unknown argument {unknown[0]!r}{hint}"
    if len(args) > len(by_place):
        others = [name for name in by_name if name not in by_place]
        accepted = f"only {' and '.join(by_place)}" if by_place else "no argument"
        hint = f"; give others by name: {', '.join(others)}" if others else ""
        return f"accepts {accepted} by position{hint}"
    given = {*kwargs, *by_place[: len(args)]}
    missing = [name for name, each in single.items() if each.default is Parameter.empty and name not in given]
    return f"give {' and '.join(missing)}" if missing else "an argument is given twice"
