"""What people read: numbers, quantities and times, and what messages say of what was found and allowed."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from difflib import get_close_matches
from fractions import Fraction
from numbers import Integral
from typing import Any

from hydrofdi.units import parse_unit

K_I_UNIT = "m^3.5/kg^0.5"
"""Unit of the leakage coefficient in base units."""

HOLE = "–"
"""What people read in place of a value that is missing."""

_LEAST_PERCENT = 1e-4
"""Percentage below which digits are meaningless [%]."""

_LEAST_PLAIN, _MOST_PLAIN = 1e-9, 1e9
"""Range of magnitudes written without an exponent."""

_READABLE = {
    "Pa": (("MPa", 1e6), ("kPa", 1e3)),
    "m^3/s": (("L/min", 0.0),),
    "m³/s": (("L/min", 0.0),),
    "m": (("m", 1.0), ("mm", 1e-4), ("µm", 0.0)),
    "m/s": (("m/s", 1.0), ("mm/s", 0.0)),
    "m^2": (("mm^2", 0.0),),
    "m^3": (("cm^3", 0.0),),
    "s": (("s", 0.1), ("ms", 0.0)),
    "N": (("kN", 1e4), ("N", 0.0)),
    "N/m": (("MN/m", 1e7), ("kN/m", 1e4), ("N/m", 0.0)),
    "m/V": (("µm/V", 0.0),),
    "Pa/V": (("MPa/V", 1e6), ("kPa/V", 0.0)),
    "rad": (("deg", 0.0),),
}
"""SI unit → units that a person reads, and from which size on."""


def readable_unit(own: str, largest: float) -> str:
    """The unit in which a person reads numbers up to `largest` [in `own`, SI]; `own` where there is none."""
    units = _READABLE.get(own, ())
    if units and largest == 0.0:
        return own if own in dict(units) else units[-1][0]
    return next((unit for unit, least in units if largest >= least or math.isclose(largest, least)), own)


def written_units(own: str) -> list[str]:
    """Units in which people write a quantity of an SI unit, the most usual first."""
    read = (unit for unit, _ in _READABLE.get(own, ()) if unit != own)
    return [*dict.fromkeys(({"Pa": "bar", "K": "°C"}.get(own, own), *read, own))]


def convert(value: float, unit: str, own: str = "") -> float:
    """A value in SI expressed in `unit`, e.g. ``convert(2e-6, "L/min")`` is 0.12.

    NaN and ∞ stay, as does a value without a unit, or in its `own`.
    """
    if unit in ("", own) or not math.isfinite(value):
        return value
    return float(Fraction(value) / parse_unit(unit).factor)


def shown_quantity(value: float, own: str, stated: str = "", n_digit: int = 4) -> str:
    """A value in SI in a unit that is stated, or else in one that suits it, such as ``8.6 MPa``."""
    unit = stated if stated not in ("", own) else readable_unit(own, abs(value))
    number = number_text(convert(value, unit, own), n_digit)
    return number if unit == "1" else f"{number} {typeset(unit)}"


def number_text(value: Any, n_digit: int = 4, scale: float = 1.0) -> str:
    """A value as people read it: four digits, no exponents up to 10 million, a dash if it is missing."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return HOLE
    if not isinstance(value, float):
        return str(value)
    scaled = value * scale
    is_whole = 10.0**n_digit - 0.5 <= abs(scaled) < 1e7
    return f"{scaled:.0f}" if is_whole else f"{scaled:.{n_digit}g}"


def typeset(unit: str) -> str:
    """A unit as it is printed: ``N·s/m`` for ``N*s/m``, ``µm`` for ``um``, ``m³/s/√Pa`` for that of K_i."""
    printed = re.sub(r"\bu(?=[A-Za-z])", "µ", unit).replace("*", "·").replace(K_I_UNIT, "m³/s/√Pa")
    return re.sub(r"\^([23])(?![\d.])", lambda power: "²" if power[1] == "2" else "³", printed)


def shown_bytes(count: int) -> str:
    """A size such as ``0.9 MB`` or ``66.8 GB``."""
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.1f} MB"


def percent(share: float) -> str:
    """A fraction as a percentage with three digits and the percent sign."""
    return f"{percentage(share)} %"


def percentage(share: float) -> str:
    """The same without the percent sign, e.g. for the lower end of a range."""
    value = 100.0 * share
    return f"below {_LEAST_PERCENT:.4f}" if 0.0 < value < _LEAST_PERCENT else f"{value:.3g}"


def plain(value: float, n_digit: int) -> str:
    """A number with `n_digit` significant digits; only extreme values have an exponent."""
    if not value or not _LEAST_PLAIN <= abs(value) < _MOST_PLAIN:
        return f"{value:.{n_digit}g}"
    import numpy as np

    return np.format_float_positional(value, n_digit, unique=False, fractional=False, trim="-")


def count_text(number: float) -> str:
    """A mean count, rounded for reading."""
    return f"{number:,.0f}" if number >= 9.95 else plain(number, 2)


def time_text(seconds: float) -> str:
    """A duration in seconds, minutes or hours."""
    size, unit = (3600.0, "h") if seconds >= 3600.0 else (60.0, "min") if seconds >= 60.0 else (1.0, "s")
    value = seconds / size
    return f"{value:,.0f} {unit}" if value >= 999.5 else f"{value:.3g} {unit}"


def two_digits(value: float) -> str:
    """A number with two digits, never as a power of ten where it has up to six."""
    return f"{float(f'{value:.2g}'):g}"


_SYNONYMS = {
    "leak": "internal_flow", "oil": "fluid", "bore": "piston_area", "rod": "piston_area_2",
    "mounting": "inclination", "angle": "inclination", "tilt": "inclination", "jobs": "workers",
}  # fmt: skip
_MOST_LISTED, _MOST_CHOICES = 12, 6

_LIMITS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than_equal": ("at most", "le"),
}

_EXPECTED = {
    **dict.fromkeys(
        ("model_type", "model_attributes_type", "dict_type"), "a section with 'key: value' pairs"
    ),
    **dict.fromkeys(("int_type", "int_from_float", "int_parsing"), "an integer"),
    **dict.fromkeys(("bool_type", "bool_parsing"), "true or false"),
    **dict.fromkeys(("tuple_type", "list_type"), "a list"),
    "string_type": "a text",
    "string_pattern_mismatch": "a name of letters, digits, '.', '_' and '-', such as 'd1'",
}
"""Kind of an error of pydantic → what is allowed."""


def nearest(name: str, known: Sequence[str], elsewhere: Sequence[str] = ()) -> str:
    """The end of a message on an unknown name: the known one that is probably meant, or all if few."""
    same = [key for key in elsewhere if _last(key) in (name, _SYNONYMS.get(_plain(name)))]
    moved = f"; did you mean {' or '.join(map(repr, same[:3]))}?" if same else ""
    return similar(name, known) or moved or listed(known)


def similar(name: object, known: Sequence[str]) -> str:
    """A hint at the known name that is spelt alike or begins alike; empty if there is none."""
    section, dot, word = str(name).rpartition(".")
    own = [key for key in known if key.startswith(section + dot)] if dot else []
    by_word = {_plain(_last(key)): key for key in reversed(own or known)}
    asked = _plain(word)
    if len(asked) < 2:
        return ""
    same_letter = [key for key in by_word if key[:1] == asked[0]]
    alike = get_close_matches(asked, by_word, 1, 0.8) or get_close_matches(asked, same_letter, 1, 0.6)
    sharing = sorted(own or known, key=lambda key: (-_shared_parts(word, key), len(_last(key).split("_"))))
    meant = [_plain(_SYNONYMS.get(asked, "")), asked, *alike]
    best = next((by_word[key] for key in meant if key in by_word), None)
    if not best and sharing and _shared_parts(word, sharing[0]):
        best = sharing[0]
    return f"; did you mean {best!r}?" if best else ""


def _shared_parts(word: str, key: str) -> int:
    """How many parts of a word begin a part of a key."""
    parts = re.split(r"[._]", key.lower())
    asked = [piece for piece in word.lower().split("_") if len(piece) > 2]
    return sum(any(part.startswith(piece) for part in parts) for piece in asked)


def listed(known: Sequence[str]) -> str:
    """All known names; empty if there are none, or too many to read."""
    return f"; known: {', '.join(known)}" if 0 < len(known) <= _MOST_LISTED else ""


def _last(name: str) -> str:
    return name.rpartition(".")[2]


def _plain(name: str) -> str:
    return re.sub(r"[-_\s]", "", name.lower())


def describe_error(error: Any, known: Sequence[str] = (), elsewhere: Sequence[str] = ()) -> str:
    """One sentence for an error of pydantic: what was found, and what is allowed."""
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    if kind in _LIMITS:
        how, limit = _LIMITS[kind]
        return out_of_range(how, context[limit], value)
    if kind in _EXPECTED:
        return f"expected {_EXPECTED[kind]}; found {brief(value)}"
    match kind:
        case "missing":
            return "is missing"
        case "extra_forbidden":
            return f"unknown key{nearest(str(error['loc'][-1]), known, elsewhere)}"
        case "literal_error" | "enum":
            choices = re.findall("'([^']*)'", context["expected"])
            if len(choices) > _MOST_CHOICES:
                return f"{brief(value)} is unknown{nearest(str(value), choices)}"
            return f"must be {context['expected']}; found {brief(value)}{similar(value, choices)}"
        case "value_error":
            message = str(context["error"]).replace(K_I_UNIT, "m³/s/√Pa; a flow is leakage.internal_flow")
            return f"{message}; found {brief(value)}" if message.startswith("expected") else message
    return f"{error['msg'][0].lower()}{error['msg'][1:]}; found {brief(value)}"


def first_reason(error: ValueError) -> str:
    """What is wrong; of an error of pydantic, the first of its mistakes."""
    errors = getattr(error, "errors", None)
    return describe_error(errors()[0]) if errors else str(error)


def out_of_range(how: str, limit: float, value: Any, unit: str = "1") -> str:
    """A number beyond its limit [in `unit`]; a number without a unit is in this one."""
    allowed = shown_quantity(limit, unit) if unit != "1" and limit else f"{limit:g}"
    own = f"{value:g} {typeset(unit)}".removesuffix(" 1") if isinstance(value, int | float) else value
    return f"must be {how} {allowed}; found {own}"


_LONGEST = 60
"""Characters of a value that messages show."""


def counted(count: float, noun: str) -> str:
    """A number and its noun: ``1 run``, ``1,200 runs``, ``2.5 periods``, ``2 entries``."""
    plural = f"{noun[:-1]}ies" if noun.endswith("y") and noun[-2:-1] not in "aeiou" else f"{noun}s"
    number = f"{count:,}" if isinstance(count, Integral) else f"{count:g}"
    return f"{number} {noun if count == 1 else plural}"


def brief(value: object) -> str:
    """A value that was found, as Python writes it; only its type if that takes more than a few words."""
    text = repr(value)
    kind = type(value).__name__
    article = "an" if kind[0].lower() in "aeio" else "a"
    return text if len(text) <= _LONGEST and "\n" not in text else f"{article} {kind}"
