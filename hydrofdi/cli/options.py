"""Options that several commands share, and options that follow from a configuration."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from functools import wraps
from inspect import Parameter, Signature, cleandoc, signature
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import typer

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Set a parameter, e.g. fluid.bulk_modulus='689 MPa'. Repeatable."
    ),
]
Config = Annotated[
    Path | None, typer.Argument(help="Experiment file, or a ready one; without it, the default actuator.")
]
Sweep = Annotated[
    Path, typer.Argument(help="Experiment file with what varies, or a ready one ('hydrofdi configs').")
]
Results = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder of the results [default: results/<name>].")
]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Worker processes [default: the cores that hydrofdi may use].")
]
Sources = Annotated[
    list[Path],
    typer.Argument(
        metavar="SOURCE...",
        help="A results folder, an experiment file (.h5, or .yaml to be simulated), a description of"
        " measured files, or one data file.",
    ),
]
Detector = Annotated[
    Path, typer.Argument(metavar="DETECTOR", help="Detector file written by 'hydrofdi train'.")
]
Figure = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Draw the signals of one record (.png, .svg or .pdf).")
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
        given = {name: value for name, value in values.items() if name not in options or value is not None}
        return command(**given)

    by_name = Parameter.KEYWORD_ONLY
    more = [Parameter(name, by_name, default=None, annotation=kind) for name, kind in options.items()]
    call.__signature__ = Signature([*stated, *more])  # type: ignore[attr-defined]
    call.__annotations__ = {each.name: each.annotation for each in (*stated, *more)}
    return call


def options_like(function: Any, *names: str) -> dict[str, Any]:
    """Name → annotation of an option, for some keywords of a function: type, default and help are its own."""
    own = signature(function).parameters
    section = cleandoc(function.__doc__).partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    texts: dict[str, str] = {}
    for part in re.split(r"\n(?=\S)", section):
        head, _, text = part.partition("\n")
        texts |= dict.fromkeys(
            head.partition(" : ")[0].split(", "), " ".join(text.replace("``", "'").replace("`", "'").split())
        )
    return {name: _like(own[name], texts[name]) for name in names}


def _like(keyword: Parameter, text: str) -> Any:
    """The option of a keyword; it is None if it is not given, so that the default of the function holds."""
    kind, default = str(keyword.annotation), keyword.default
    flag = f"--{keyword.name.replace('_', '-')}"
    if kind == "bool":
        both = f"{flag}/--no-{flag[2:]}" if default else flag
        return Annotated[bool | None, typer.Option(both, show_default=False, help=text)]
    if default and isinstance(default, str):
        text += f" [default: {default}]"
    if kind.startswith("Literal"):
        return Annotated[Literal[tuple(re.findall("'([^']*)'", kind))] | None, typer.Option(flag, help=text)]
    metavar = keyword.name.rpartition("_")[2].upper()
    if default == ():
        return Annotated[list[str] | None, typer.Option(flag, metavar=metavar, help=f"{text} Repeatable.")]
    return Annotated[str | None, typer.Option(flag, metavar=metavar, help=text)]


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
