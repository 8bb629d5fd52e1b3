"""Options that several commands share, and options that follow from Python functions and configurations."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from inspect import Parameter, Signature, cleandoc, signature
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

import typer

from hydrofdi.cli.terminal import answer

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
    Path | None,
    typer.Argument(
        help="Experiment file with what varies, or a ready one ('hydrofdi configs'); without it, the default"
        " actuator with --grid or --zip."
    ),
]
Grid = Annotated[
    list[str] | None,
    typer.Option(
        "--grid",
        metavar="NAME=AXIS",
        help="Vary a parameter: EBM=551MPa:827MPa:3 (count; with a unit step), K_i=0,1e-8, P_s=1e6:1e7:5:log."
        " Repeatable.",
    ),
]
Zip = Annotated[
    list[str] | None,
    typer.Option("--zip", metavar="NAME=AXIS", help="The same, varied together. Repeatable."),
]
Name = Annotated[str | None, typer.Option(metavar="NAME", help="Name, and folder below results/.")]
Write = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Write what the options say to this experiment file, too.")
]
Sources = Annotated[
    list[Path],
    typer.Argument(
        metavar="SOURCE...",
        help="A results folder, an experiment file (.h5, or .yaml to be simulated), a description of"
        " measured files, a data file, or a folder of data files.",
    ),
]
Directory = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of an experiment.")]
Detector = Annotated[
    Path, typer.Argument(metavar="DETECTOR", help="Detector file written by 'hydrofdi train'.")
]
Figure = Annotated[Path | None, typer.Option(metavar="FILE", help="Draw a figure (.png, .svg or .pdf).")]
Json = Annotated[bool, typer.Option("--json", help="Print only JSON on standard output.")]

SamplingFrequency = Annotated[
    str | None,
    typer.Option(
        metavar="FREQUENCY", help="Sampling frequency of a data file without a time column, e.g. 1kHz."
    ),
]

_METAVARS = {
    "s": "TIME",
    "1": "SHARE",
    "m": "LENGTH",
    "Pa": "PRESSURE",
    "kg": "MASS",
    "K": "TEMPERATURE",
    "Hz": "FREQUENCY",
}
"""Unit of a quantity → what the help writes for it."""


Found = Any
"""What a command returns that finds an answer: it is printed as text, or as JSON with ``--json``."""


def with_options(command: Callable[..., Any], options: Mapping[str, Any]) -> Callable[..., int]:
    """A command whose ``**settings`` are these options, name → annotation; those not given are left out.

    One that finds an answer gets ``--json``.
    """
    own = signature(command, eval_str=True)
    stated = [each for each in own.parameters.values() if each.kind is not Parameter.VAR_KEYWORD]
    if own.return_annotation is Found:
        stated.append(Parameter("json", Parameter.KEYWORD_ONLY, default=False, annotation=Json))

    @wraps(command)
    def call(**values: Any) -> int:
        given = {name: value for name, value in values.items() if name not in options or value is not None}
        if own.return_annotation is Found:
            as_json = given.pop("json")
            return answer(command(**given), json=as_json)
        code: int = command(**given)
        return code

    by_name = Parameter.KEYWORD_ONLY
    more = [Parameter(name, by_name, default=None, annotation=kind) for name, kind in options.items()]
    call.__signature__ = Signature([*stated, *more])  # type: ignore[attr-defined]
    call.__annotations__ = {each.name: each.annotation for each in (*stated, *more)}
    return call


def options_like(function: Any, names: Iterable[str]) -> dict[str, Any]:
    """Name → annotation of an option, for some keywords of a function: type, default and help are its own.

    An option of another name follows that of the keyword: ``flows:--flow``.
    """
    own = signature(function).parameters
    section = cleandoc(function.__doc__).partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    texts: dict[str, str] = {}
    for part in re.split(r"\n(?=\S)", section):
        head, _, text = part.partition("\n")
        texts |= dict.fromkeys(head.partition(" : ")[0].split(", "), text)
    options = {}
    for name, _, flag in (each.partition(":") for each in names):
        if name == "sampling_frequency":
            options[name] = SamplingFrequency
            continue
        kind, default = str(own[name].annotation), own[name].default
        metavar = name.rpartition("_")[2].upper()
        if "PathLike" in kind or "Experiment" in kind:
            metavar = "DIR" if "Folder" in texts[name] else "FILE"
        options[name] = _option(
            flag or f"--{name.replace('_', '-')}",
            kind.removesuffix(" | None"),
            default,
            texts[name],
            metavar,
            re.findall("'([^']*)'", kind) if kind.startswith("Literal") else (),
        )
    return options


def options_of(model: Any, keys: Mapping[str, tuple[str, ...]]) -> dict[str, Any]:
    """Name → annotation of an option, for each of these keys of a configuration whose field is no section."""
    from hydrofdi.settings.quantities import field_quantity, field_texts

    options = {}
    for name, path in keys.items():
        section = model
        for part in path[:-1]:
            kinds = section.model_fields[part].annotation
            section = next(each for each in (kinds, *get_args(kinds)) if hasattr(each, "model_fields"))
        field, text = section.model_fields[path[-1]], field_texts(section)[path[-1]]
        kinds = (field.annotation, *get_args(field.annotation))
        members = [name for each in kinds for name in getattr(each, "_value2member_map_", ())]
        choices = members or [each for each in kinds if isinstance(each, str)]
        unit = getattr(field_quantity(field), "unit", "")
        is_text = str in kinds and get_origin(field.annotation) is not dict
        if unit or choices or is_text or isinstance(field.default, bool):
            kind = "bool" if isinstance(field.default, bool) else "str"
            default = f"{100 * field.default:g} %" if unit == "1" else field.default
            options[name] = _option(
                f"--{name.replace('_', '-')}", kind, default, text, _METAVARS.get(unit, "NAME"), choices
            )
    return options


def _option(flag: str, kind: str, default: Any, text: str, metavar: str, choices: Iterable[str]) -> Any:
    """An option; it is None if it is not given, so that the default of the function or the file holds."""
    text = " ".join(text.replace("``", "'").replace("`", "'").split())
    if kind == "bool":
        both = f"{flag}/--no-{flag[2:]}" if default else flag
        return Annotated[bool | None, typer.Option(both, show_default=False, help=text)]
    if default == ():
        return Annotated[list[str] | None, typer.Option(flag, metavar=metavar, help=f"{text} Repeatable.")]
    if default and isinstance(default, str | float) and "default" not in text:
        text += f" [default: {default}]"
    if choices := tuple(choices):
        return Annotated[Literal[choices] | None, typer.Option(flag, help=text)]
    if kind == "int":
        return Annotated[int | None, typer.Option(flag, help=text)]
    return Annotated[str | None, typer.Option(flag, metavar=metavar, help=text)]
