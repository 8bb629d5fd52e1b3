"""Registry of indicators, built-in ones and those of other packages and of files, and their descriptions.

A package adds indicators by entry points in the group ``hydrofdi.indicators``::

    [project.entry-points."hydrofdi.indicators"]
    peak = "my_package:Peak"

An experiment may name Python files; ``swing@…`` is the ``swing`` of a file with that hash. Only an experiment
that the user gives has files executed; worker processes get their content with the jobs.
"""

from __future__ import annotations

import hashlib
import re
import sys
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.faults import fault_of_declaration
from hydrofdi.records import Channel
from hydrofdi.settings.files import Source
from hydrofdi.settings.messages import brief, nearest, shown_quantity
from hydrofdi.settings.quantities import field_quantity, field_texts

LABEL_PATTERN = "^[A-Za-z][A-Za-z0-9_-]{0,63}$"


_IN_FILES = """
run time level phase run_id record_id status message verdict bulk_modulus fixed_baseline_run
matched_baseline_run internal_leakage_level internal_leakage_coefficient internal_leakage_flow
chamber_1_pressure chamber_2_pressure piston_position piston_velocity spool_position input_voltage
reference_position load_force valve_supply_pressure detail_rms approximation_rms phase_detail_rms
settled_detail_rms settled_approximation_rms settled_phase_detail_rms settled_from settling_change
mean_chamber_1_pressure mean_internal_leakage_flow mean_external_leakage_flow_1 mean_external_leakage_flow_2
chamber_1_pressure_min chamber_1_pressure_max chamber_2_pressure_min chamber_2_pressure_max
piston_position_min piston_position_max above_supply_share cavitating_share clipped_share pressure_variation
unusual_share volume_residual energy_residual hydraulic_mode_frequency hydraulic_mode_damping_ratio
"""


TAKEN = frozenset(_IN_FILES.split())
"""Variables and dimensions of an experiment file."""


def label_mistake(label: object, of: str = "an indicator") -> str | None:
    """Message if a label is not valid, else None."""
    if not isinstance(label, str) or not re.fullmatch(LABEL_PATTERN, label):
        rule = "letters, digits, '_' and '-', beginning with a letter, at most 64"
        return f"is not a valid label of {of} ({rule})"
    if label in TAKEN:
        return "is the name of a variable of experiment files; choose another label and add 'kind: NAME'"
    return None


GROUP = "hydrofdi.indicators"

_DECLARED = ("version", "summary", "source", "Options", "channels", "outputs", "measure")
"""Attributes that every indicator must declare."""

_NAMES = {
    "balances": ("flow_balance", "pressure_balance", "weak_rls"),
    "kalman_filters": ("ekf_innovation", "ekf_joint", "ukf_joint"),
    "modes": ("emd", "vmd"),
    "observers": ("adaptive_observer", "reduced_order"),
    "pressures": ("cross_correlation", "pressure_decay", "pressure_statistics"),
    "ring_down": ("ring_down",),
    "sliding": ("sliding",),
    "spectra": ("band_power", "stft"),
    "transients": ("envelope", "post_step_ac"),
    "volterra": ("volterra",),
    "wavelets": ("a4", "dwt", "modwt", "wavelet_packet"),
}
"""Module of the catalogue → its indicators."""

_HOMES = {name: module for module, names in _NAMES.items() for name in names}

Kind = type[Indicator[Any]]

FROM_FILES: dict[str, Kind] = {}
"""Name with hash → indicator of a file that an experiment named in this process."""


def indicator_names() -> list[str]:
    """Names of all indicators, sorted."""
    return sorted({*_HOMES, *_added()})


@cache
def indicator_kind(name: str) -> Kind:
    """The class of an indicator.

    Raises
    ------
    ConfigError
        There is no indicator of this name, or the package that adds it cannot be loaded.
    """
    if name in FROM_FILES:
        return FROM_FILES[name]
    if name in _HOMES:
        return _own(name)
    if name in _added():
        return _load(_added()[name])
    raise ConfigError(f"there is no indicator {name!r}{nearest(name, indicator_names())}")


def sound_indicator(name: str, options: Mapping[str, Any] | None = None) -> Indicator[Any]:
    """Make an indicator with options, and check its declaration."""
    kind = indicator_kind(name)
    chosen = kind.Options.model_validate(dict(options or {}))
    try:
        indicator = kind(chosen)
        fault = fault_of_declaration(indicator)
    except Exception as error:
        raise ConfigError(f"indicator {name!r} is faulty: {type(error).__name__}: {error}") from error
    if fault:
        raise ConfigError(f"indicator {name!r} is faulty: {fault}")
    return indicator


def _own(name: str) -> Kind:
    module = import_module(f"hydrofdi.indicators.catalogue.{_HOMES[name]}")
    kinds = [kind for kind in vars(module).values() if getattr(kind, "name", None) == name]
    (kind,) = (kind for kind in kinds if isinstance(kind, type))
    return kind


@cache
def _added() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP)}


def _load(point: EntryPoint) -> Kind:
    try:
        kind: Kind = point.load()
    except Exception as error:
        raise ConfigError(f"indicator {point.name!r}: {point.value} cannot be loaded: {error}") from None
    if not isinstance(kind, type) or getattr(kind, "name", None) != point.name:
        raise ConfigError(f"indicator {point.name!r}: {point.value} is not an indicator of this name")
    require_declared(kind, point.value)
    return kind


def require_declared(kind: Kind, origin: str) -> None:
    """Check that an indicator has all that it must declare."""
    missing = [part for part in _DECLARED if not hasattr(kind, part)]
    if missing or not isinstance(kind.version, int):
        fault = f"has no {' and no '.join(missing)}" if missing else "has a version that is not an integer"
        raise ConfigError(f"indicator {kind.name!r}: {origin} {fault}")


@dataclass(frozen=True)
class Option:
    """An option of an indicator.

    Attributes
    ----------
    default : str
        With a unit that suits it, as a configuration may state it; ``–`` if there is none.
    unit : str
        SI; ``1`` for dimensionless numbers, empty if the option is not a quantity.
    text : str
        Description.
    """

    name: str
    default: str
    unit: str
    text: str


@dataclass(frozen=True)
class Description:
    """An indicator with its default outputs and channels."""

    name: str
    version: int
    summary: str
    source: str
    equation: str
    caution: str
    is_cheap: bool
    needs_scale: bool
    channels: tuple[Channel, ...]
    optional_channels: tuple[Channel, ...]
    outputs: tuple[Output, ...]
    options: tuple[Option, ...]

    @property
    def cost(self) -> str:
        """Cost class, for tables."""
        return "cheap" if self.is_cheap else "costly"


def describe(name: str) -> Description:
    """Describe an indicator."""
    kind = indicator_kind(name)
    indicator, texts = sound_indicator(name), field_texts(kind.Options)
    options = []
    for field, info in kind.Options.model_fields.items():
        quantity, default = field_quantity(info), info.get_default(call_default_factory=True)
        unit = quantity.unit if quantity else ""
        options.append(Option(field, _shown(default, unit), unit, " ".join(texts.get(field, "").split())))
    return Description(
        name, kind.version, kind.summary, kind.source, kind.equation, kind.caution, kind.is_cheap,
        kind.needs_scale,
        tuple(sorted(indicator.channels)), tuple(sorted(indicator.optional_channels)),
        tuple(indicator.outputs), tuple(options),
    )  # fmt: skip


def _shown(value: Any, unit: str) -> str:
    if value is None or value in ((), [], {}):
        return "–"
    if isinstance(value, tuple | list):
        return ", ".join(_shown(item, unit) for item in value)
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, float):
        return shown_quantity(value, unit or "1")
    return str(value)


_SOURCES: dict[str, tuple[str, bytes]] = {}
"""Hash → path and content of each file that was executed."""


def load_plugins(source: Source) -> dict[str, str]:
    """Execute the files in ``plugins`` of an experiment; these then are path → SHA-256.

    Returns
    -------
    dict of str to str
        Name of each of their indicators → the name with the hash.

    Raises
    ------
    ConfigError
        A file cannot be read, raises an exception, or defines no indicator, or one with a name of another.
    """
    given = source.data.get("plugins") or []
    paths = [given] if isinstance(given, str) else given
    if not isinstance(paths, list) or not all(isinstance(path, str) for path in paths):
        message = f"expected the path of a Python file, or a list of paths; found {brief(given)}"
        raise ConfigError([source.mistake(("plugins",), message)])
    names: dict[str, str] = {}
    hashes: dict[str, str] = {}
    for index, path in enumerate(paths):
        here = ("plugins", index) if paths is given else ("plugins",)
        try:
            content, whole = Path(path).read_bytes(), str(Path(path).resolve())
            own = load_plugin(whole, content)
        except (OSError, ConfigError) as error:
            source.report(here, f"{path}: {error.strerror}" if isinstance(error, OSError) else str(error))
            continue
        if twice := names.keys() & own.keys():
            source.report(here, f"{path}: {min(twice)!r} is the name of another indicator")
        names |= own
        hashes[whole] = hashlib.sha256(content).hexdigest()
    if paths and source.mistakes:
        raise ConfigError(source.mistakes)
    if "plugins" in source.data:
        source.data["plugins"] = hashes
    return names


def load_plugin(path: str, content: bytes) -> dict[str, str]:
    """Execute a file, once in a process; `load_plugins` of one."""
    mark = f"@{hashlib.sha256(content).hexdigest()[:16]}"
    if mark not in _SOURCES:
        kinds = _kinds(path, content, f"plugin{mark}")
        for kind in kinds:
            kind.name += mark
            FROM_FILES[kind.name] = kind
        _SOURCES[mark] = path, content
    return {name.removesuffix(mark): name for name in FROM_FILES if name.endswith(mark)}


def sources_in(text: str) -> list[tuple[str, bytes]]:
    """Path and content of the files whose indicators a text names."""
    return [source for mark, source in _SOURCES.items() if mark in text]


def _kinds(path: str, content: bytes, module_name: str) -> list[Kind]:
    module = ModuleType(module_name)
    module.__file__ = path
    sys.modules[module_name] = module  # where pydantic looks up the annotations of options
    try:
        exec(compile(content, path, "exec", dont_inherit=True), vars(module))
    except (Exception, SystemExit) as error:
        frames = traceback.extract_tb(error.__traceback__)
        lines = [each.lineno for each in frames if each.filename == path]
        line = f" ({Path(path).name}:{lines[-1]})" if lines else ""
        raise ConfigError(f"{path}: raised {type(error).__name__}: {error}{line}") from None
    kinds = list(dict.fromkeys(each for each in vars(module).values() if _is_own(each, module_name)))
    if not kinds:
        raise ConfigError(f"{path}: defines no indicator, a subclass of Indicator with a name")
    for kind in kinds:
        require_declared(kind, path)
        mistake = label_mistake(kind.name)
        if mistake or kind.name in indicator_names() or [each.name for each in kinds].count(kind.name) > 1:
            raise ConfigError(f"{path}: {kind.name!r} {mistake or 'is the name of another indicator'}")
    return kinds


def _is_own(value: Any, module_name: str) -> bool:
    is_indicator = isinstance(value, type) and Indicator in value.__mro__ and hasattr(value, "name")
    return is_indicator and value.__module__ == module_name
