"""Units that an unknown spelling may stand for."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice, product

from hydrofdi.units.expressions import MOST_CHARACTERS, parse_unit
from hydrofdi.units.symbols import PREFIXABLE, PREFIXES, SYMBOLS

SPELLINGS = {
    "s": "sec, secs, second, seconds",
    "ms": "msec, msecs, millisecond, milliseconds",
    "us": "usec, µsec, microsecond, microseconds",
    "min": "mins, minute, minutes",
    "h": "hr, hrs, hour, hours",
    "Hz": "hertz, cps",
    "1/min": "rpm",
    "m": "meter, meters, metre, metres",
    "mm": "millimeter, millimeters, millimetre, millimetres",
    "cm": "centimeter, centimeters, centimetre, centimetres",
    "µm": "micron, microns, micrometer, micrometre",
    "in": 'inch, inches, "',
    "ft": "foot, feet",
    "mm²": "sqmm",
    "cm²": "sqcm",
    "in²": "sqin",
    "cm³": "cc, ccm",
    "L": "ltr, ltrs, lit, liter, liters, litre, litres",
    "mL": "milliliter, milliliters, millilitre, millilitres",
    "L/min": "lpm, l/m, lmin, lmn",
    "mL/min": "mlpm",
    "galUS or galUK": "gal, gals, gallon, gallons",
    "galUS/min or galUK/min": "gpm",
    "galUS/min": "usgpm",
    "kg": "kgs, kilo, kilos, kilogram, kilograms",
    "t": "tonne, tonnes",
    "lb": "lbs, pound, pounds",
    "lbf": "lbsf",
    "kgf": "kp, kilopond",
    "N": "newton, newtons",
    "N·m": "nm",
    "N·s": "ns",
    "Pa": "pascal, pascals",
    "bar": "bars, barg, bara, bar(g), bar(a)",
    "psi": "psig, psia, lbf/in2",
    "kpsi": "ksi",
    "V": "volt, volts",
    "A": "amp, amps, ampere, amperes",
    "m/s": "mps",
    "%": "percent, pct",
}
"""Symbol or expression → other spellings, in small letters."""

_MEANT = {name: [*meant.split(" or ")] for meant, text in SPELLINGS.items() for name in text.split(", ")}
_KNOWN = [*SYMBOLS, *(prefix + stem for prefix in PREFIXES for stem in sorted(PREFIXABLE))]
_WORD = re.compile(r"[A-Za-zµμ]+|\"")
_BARE_POWER = re.compile(r"(?<=[a-zA-Zµμ])(?:\*\*|\^)?([23])(?![\d.])")
"""A power as in ``cm2``, ``cm^2`` and ``cm**2``."""
_RAISED = {"2": "²", "3": "³"}
_MOST_READINGS = 100


def similar_units(text: str, unit: str) -> list[str]:
    """Units of the dimension of `unit` that an unknown spelling such as ``Bar`` or ``sec`` may stand for.

    Parameters
    ----------
    text : str
        A spelling that `parse_unit` refuses.
    unit : str
        A unit of the dimension that is wanted.
    """
    if len(text) > MOST_CHARACTERS:
        return []
    wanted = parse_unit(unit).exponents
    return [reading for reading in dict.fromkeys(_readings(text.strip())) if _dimension(reading) == wanted]


def _readings(text: str) -> Iterator[str]:
    """All spellings that hydrofdi knows and that the text may stand for."""
    whole = text.rstrip(".").lower()
    if whole in _MEANT:
        yield from _MEANT[whole]
        return
    plain = _BARE_POWER.sub(lambda power: _RAISED[power[1]], text.rstrip("."))
    plain = re.sub(r"(?<=\w)[-.](?=[A-Za-z])", "·", plain)
    pieces, words = _WORD.split(plain), _WORD.findall(plain)
    for chosen in islice(product(*map(_words, words)), _MOST_READINGS):
        yield "".join(piece + word for piece, word in zip(pieces, [*chosen, ""], strict=True))


def _words(word: str) -> list[str]:
    """What one word of an expression may stand for; itself if it is known."""
    if word in _KNOWN:
        return [word]
    if word.lower() in _MEANT:
        return _MEANT[word.lower()]
    found = [known for known in dict.fromkeys(_KNOWN) if known.lower() == word.lower()]
    is_mixed = word.lower() != word
    return [known for known in found if is_mixed and known[0] == word[0]] or found


def _dimension(text: str) -> object:
    try:
        return parse_unit(text).exponents
    except ValueError:
        return None
