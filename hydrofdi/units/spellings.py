"""Units that an unknown spelling may stand for."""

from __future__ import annotations

import re
from itertools import islice, product

from hydrofdi.units.expressions import MOST_CHARACTERS, parse_unit
from hydrofdi.units.symbols import PREFIXABLE, PREFIXES, SYMBOLS

SPELLINGS = {
    "s": "sec second seconds", "ms": "msec", "h": "hr hour hours", "Hz": "hertz cps", "1/min": "rpm",
    "in": "inch inches", "ft": "foot feet", "µm": "micron microns", "mm²": "sqmm", "cm³": "cc ccm",
    "L": "liter liters litre litres ltr", "L/min": "lpm", "mL/min": "mlpm", "galUS": "gal gallon gallons",
    "galUS/min": "gpm usgpm", "galUK/min": "gpm", "kgf": "kp", "lb": "lbs", "N·m": "nm",
    "bar": "bars barg bara", "psi": "psig psia", "kpsi": "ksi", "V": "volt volts", "A": "amp amps",
    "m/s": "mps", "%": "percent pct",
}  # fmt: skip
"""Symbol or expression → other spellings, in small letters."""

_WORD = re.compile(r"[A-Za-zµμ]+")
_BARE_POWER = re.compile(r"(?<=[a-zA-Zµμ])(?:\*\*|\^)?([23])(?![\d.])")
_KNOWN = [*SYMBOLS, *(prefix + stem for prefix in PREFIXES for stem in sorted(PREFIXABLE))]
_MOST_READINGS = 100


def similar_units(text: str, unit: str) -> list[str]:
    """Units of the dimension of `unit` that a spelling which `parse_unit` refuses may stand for."""
    plain = _BARE_POWER.sub(lambda power: "²³"[int(power[1]) - 2], text.strip(" .")[:MOST_CHARACTERS])
    plain = re.sub(r"(?<=\w)[-.](?=[A-Za-z])", "·", plain)
    pieces, words = _WORD.split(plain), _WORD.findall(plain)
    wanted, found = parse_unit(unit).exponents, []
    for chosen in islice(product(*map(_meant, words)), _MOST_READINGS):
        reading = "".join(piece + word for piece, word in zip(pieces, [*chosen, ""], strict=True))
        try:
            if parse_unit(reading).exponents == wanted:
                found.append(reading)
        except ValueError:
            continue
    return list(dict.fromkeys(found))


def _meant(word: str) -> list[str]:
    """What one word of an expression may stand for; itself if it is known."""
    if word in _KNOWN:
        return [word]
    small = word.lower()
    if spelt := [unit for unit, names in SPELLINGS.items() if small in names.split()]:
        return spelt
    found = [known for known in _KNOWN if known.lower() == small]
    return [known for known in found if word != small and known[0] == word[0]] or found
