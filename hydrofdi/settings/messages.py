"""What messages say: what was found, what is allowed, and the nearest name that is known."""

from __future__ import annotations

import re
from collections.abc import Sequence
from difflib import get_close_matches
from numbers import Integral
from typing import Any

from hydrofdi.settings.readable import shown_quantity, typeset

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
    found = next((by_word[key] for key in meant if key in by_word), None)
    if not found and sharing and _shared_parts(word, sharing[0]):
        found = sharing[0]
    return f"; did you mean {found!r}?" if found else ""


def _shared_parts(word: str, key: str) -> int:
    """How many parts of a word begin a part of a key."""
    parts = re.split(r"[._]", key.lower())
    asked = [each for each in word.lower().split("_") if len(each) > 2]
    return sum(any(part.startswith(each) for part in parts) for each in asked)


def listed(known: Sequence[str]) -> str:
    """All known names; empty if there are none, or too many to read."""
    return f"; known: {', '.join(known)}" if 0 < len(known) <= _MOST_LISTED else ""


def _last(name: str) -> str:
    return name.rpartition(".")[2]


def _plain(name: str) -> str:
    return re.sub(r"[-_\s]", "", name.lower())


def describe_error(error: Any, known: Sequence[str] = (), elsewhere: Sequence[str] = ()) -> str:
    """One sentence for an error of pydantic: what was found, and what is allowed."""
    kind, found, context = error["type"], error["input"], error.get("ctx", {})
    if kind in _LIMITS:
        how, limit = _LIMITS[kind]
        return out_of_range(how, context[limit], found)
    if kind in _EXPECTED:
        return f"expected {_EXPECTED[kind]}; found {brief(found)}"
    match kind:
        case "missing":
            return "is missing"
        case "extra_forbidden":
            return f"unknown key{nearest(str(error['loc'][-1]), known, elsewhere)}"
        case "literal_error" | "enum":
            choices = re.findall("'([^']*)'", context["expected"])
            if len(choices) > _MOST_CHOICES:
                return f"{brief(found)} is unknown{nearest(str(found), choices)}"
            return f"must be {context['expected']}; found {brief(found)}{similar(found, choices)}"
        case "value_error":
            message = str(context["error"])
            return f"{message}; found {brief(found)}" if message.startswith("expected") else message
    return f"{error['msg'][0].lower()}{error['msg'][1:]}; found {brief(found)}"


def first_reason(error: ValueError) -> str:
    """What is wrong; of an error of pydantic, the first of its mistakes."""
    errors = getattr(error, "errors", None)
    return describe_error(errors()[0]) if errors else str(error)


def out_of_range(how: str, limit: float, found: Any, unit: str = "1") -> str:
    """A number beyond its limit [in `unit`]; a number without a unit is in this one."""
    allowed = shown_quantity(limit, unit) if unit != "1" and limit else f"{limit:g}"
    own = f"{found:g} {typeset(unit)}".removesuffix(" 1") if isinstance(found, int | float) else found
    return f"must be {how} {allowed}; found {own}"


_LONGEST = 60
"""Characters of a value that messages show."""


def counted(count: float, noun: str) -> str:
    """A number and its noun: ``1 run``, ``1,200 runs``, ``2.5 periods``, ``2 entries``."""
    plural = f"{noun[:-1]}ies" if noun.endswith("y") and noun[-2:-1] not in "aeiou" else f"{noun}s"
    number = f"{count:,}" if isinstance(count, Integral) else f"{count:g}"
    return f"{number} {noun if count == 1 else plural}"


def brief(found: object) -> str:
    """A value that was found, as Python writes it; only its type if that takes more than a few words."""
    text = repr(found)
    kind = type(found).__name__
    article = "an" if kind[0].lower() in "aeio" else "a"
    return text if len(text) <= _LONGEST and "\n" not in text else f"{article} {kind}"
