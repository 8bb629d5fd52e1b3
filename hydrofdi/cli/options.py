"""Options that several commands share, and options that follow from a configuration."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import wraps
from inspect import Parameter, Signature, signature
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import typer

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Set a parameter, e.g. fluid.bulk_modulus='689 MPa'. Repeatable."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print only JSON on standard output.")]
SamplingFrequency = Annotated[
    str | None,
    typer.Option(
        metavar="FREQUENCY", help="Sampling frequency of a data file without a time column, e.g. 1kHz."
    ),
]

_METAVARS = {"s": "TIME", "1": "SHARE"}
"""Unit of a quantity → what the help writes for it."""


def with_options(command: Callable[..., int], options: Mapping[str, Any]) -> Callable[..., int]:
    """A command whose ``**settings`` are these options, name → annotation; those not given are None."""
    own = signature(command, eval_str=True).parameters.values()
    stated = [each for each in own if each.kind is not Parameter.VAR_KEYWORD]
    if len(stated) == len(own):
        return command

    @wraps(command)
    def call(**values: Any) -> int:
        return command(**values)

    by_name = Parameter.KEYWORD_ONLY
    more = [Parameter(name, by_name, default=None, annotation=kind) for name, kind in options.items()]
    call.__signature__ = Signature([*stated, *more])  # type: ignore[attr-defined]
    call.__annotations__ = {each.name: each.annotation for each in (*stated, *more)}
    return call


def options_of(model: Any, keys: Mapping[str, tuple[str, ...]]) -> dict[str, Any]:
    """Name → annotation of an option, for each of these keys of a configuration whose field is no section."""
    found = {name: _option(name, model, path) for name, path in keys.items()}
    return {name: annotation for name, annotation in found.items() if annotation is not None}


def _option(name: str, model: Any, path: tuple[str, ...]) -> Any:
    """An option whose help, choices, unit and default are those of a field; None of sections and mappings."""
    from hydrofdi.settings.quantities import SI
    from hydrofdi.settings.schema import field_texts
    from hydrofdi.settings.yaml_source import scalar

    for part in path[:-1]:
        model = model.model_fields[part].annotation
    field = model.model_fields[path[-1]]
    kind, metadata = next(_kinds(field.annotation, field.metadata))
    text = " ".join(field_texts(model)[path[-1]].replace("``", "'").split())
    quantity = next((each for each in metadata if isinstance(each, SI)), None)
    if quantity is not None:
        default = f"{100 * field.default:g} %" if quantity.unit == "1" else field.default
        text += f" [default: {default}]" if field.default is not None else ""
        metavar = _METAVARS.get(quantity.unit, "NUMBER")
        return Annotated[str | None, typer.Option(metavar=metavar, parser=scalar, help=text)]
    text += f" [default: {field.default}]" if field.default else ""
    if kind is bool:
        return Annotated[bool | None, typer.Option(f"--{name}", help=text)]
    if kind is str:
        return Annotated[str | None, typer.Option(metavar="NAME", help=text)]
    choices = get_args(kind) if get_origin(kind) is Literal else getattr(kind, "__members__", ())
    return Annotated[kind | None, typer.Option(help=text)] if choices else None


def _kinds(annotation: Any, metadata: list[Any]) -> Iterator[tuple[Any, list[Any]]]:
    """Types of an annotation but None, each with what annotates it."""
    several = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else (annotation,)
    for each in several:
        if each is not type(None):
            more = [*getattr(each, "__metadata__", ())]
            yield (get_args(each)[0] if more else each), [*metadata, *more]
