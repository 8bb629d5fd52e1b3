"""What pydantic says of a value, in the words of a user."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from typing import Any

from hydrofdi.settings.computed import computation
from hydrofdi.settings.synonyms import meant, plain_word

_MOST_MEANT = 3


def describe_error(error: Any, known: Sequence[str] = (), elsewhere: Sequence[str] = ()) -> str:
    """One sentence on an error of pydantic: what was found, what is allowed."""
    found, context = error["input"], error.get("ctx", {})
    match error["type"]:
        case "extra_forbidden":
            return f"unknown key{nearest(str(error['loc'][-1]), known, elsewhere)}"
        case "greater_than":
            return f"must be greater than {context['gt']:g}; found {found}"
        case "greater_than_equal":
            return f"must be at least {context['ge']:g}; found {found}"
        case "less_than_equal":
            return f"must be at most {context['le']:g}; found {found}"
        case "finite_number":
            return f"must be a finite number; found {found}"
        case "literal_error":
            return f"must be {context['expected']}; found {found!r}"
        case "enum":
            return f"{found!r} is unknown{nearest(str(found), _quoted(context['expected']))}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"expected a section with 'key: value' pairs; found {found!r}"
        case "tuple_type" | "list_type":
            return f"expected a list; found {found!r}"
        case "too_short":
            least = context["min_length"]
            return f"needs {least} entr{'y' if least == 1 else 'ies'} or more; found {len(found)}"
        case "json_invalid":
            return f"is not JSON: {context['error']}"
        case "missing":
            return "is missing"
        case "string_pattern_mismatch" if error["loc"][-1] == "level":
            return f"must be d1, d2, …; found {found!r}"
        case "string_pattern_mismatch":
            return f"letters, digits, '.', '_' and '-' only, at most 64; found {found!r}"
        case "value_error":
            found_text = f"; found {found!r}" if str(context["error"]).startswith("expected") else ""
            return f"{context['error']}{found_text}"
    return f"{error['msg'][0].lower()}{error['msg'][1:]}; found {found!r}"


def _quoted(text: str) -> list[str]:
    return re.findall("'([^']*)'", text)


def nearest(name: str, known: Sequence[str], elsewhere: Sequence[str] = ()) -> str:
    """A hint at the known name that an unknown one probably means; empty where there is none.

    Parameters
    ----------
    name : str
    known : sequence of str
        What may stand there.
    elsewhere : sequence of str
        Dotted names of what stands in other sections.
    """
    if keys := meant(name, known):
        return _did_you_mean(keys)
    if how := computation(plain_word(name).rpartition(".")[2], [*known, *elsewhere]):
        return how
    if keys := meant(name, elsewhere):
        return _did_you_mean(keys)
    if close := _close(name, known):
        return _did_you_mean([close])
    return f"; known are {', '.join(known)}" if 0 < len(known) <= 12 else ""


def _did_you_mean(keys: Sequence[str]) -> str:
    others = "" if len(keys) <= _MOST_MEANT else ", or that of another section"
    shown = keys[:1] if others else keys
    return f"; did you mean {' or '.join(map(repr, shown))}{others}?"


def _close(name: str, known: Sequence[str]) -> str:
    """The known name that is spelt alike, or has the same words; empty where there is none."""
    longer = sorted((each for each in known if len(name) > 2 and each.startswith(name)), key=len)
    words = set(name.split("_"))
    longer = longer or [each for each in known if len(words) > 1 and words < set(each.split("_"))]
    if longer and all(each.startswith(longer[0]) for each in longer):
        return longer[0]
    return next(iter(difflib.get_close_matches(name, known, n=1, cutoff=0.5)), "")
