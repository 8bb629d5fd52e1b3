"""Errors of pydantic as sentences for users."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from hydrofdi.settings.counting import counted
from hydrofdi.settings.suggestions import nearest, similar

_MOST_SHOWN = 200


def describe_error(
    error: Any, known: Sequence[str] = (), elsewhere: Sequence[str] = (), unit: str = ""
) -> str:
    """One sentence for an error of pydantic: what was found, and what is allowed, in a unit."""
    found, context = error["input"], error.get("ctx", {})
    match error["type"]:
        case "extra_forbidden":
            section, name = ("", *map(str, error["loc"]))[-2:]
            return f"unknown key{nearest(name, known, elsewhere, section)}"
        case "greater_than":
            return f"must be greater than {_limit(context['gt'], unit)}; found {_number(found)}"
        case "greater_than_equal":
            return f"must be at least {_limit(context['ge'], unit)}; found {_number(found)}"
        case "less_than_equal":
            most = context["le"]
            return f"must be at most {_limit(most, unit)}; found {_number(found)}{percent_hint(found, most)}"
        case "finite_number":
            return f"must be a finite number; found {found}"
        case "literal_error":
            choices = context["expected"]
            return f"must be {choices}; found {_shown(found)}{similar(found, _quoted(choices))}"
        case "enum":
            return f"{found!r} is unknown{nearest(str(found), _quoted(context['expected']))}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"expected a section with 'key: value' pairs; found {_shown(found)}"
        case "string_type":
            return f"expected a text; found {_shown(found)}"
        case "int_type" | "int_from_float" | "int_parsing":
            return f"expected an integer; found {_shown(found)}"
        case "bool_type" | "bool_parsing":
            return f"expected true or false; found {_shown(found)}"
        case "tuple_type" | "list_type":
            return f"expected a list; found {_shown(found)}"
        case "too_short":
            return f"needs {counted(context['min_length'], 'entry')} or more; found {len(found)}"
        case "json_invalid":
            return f"is not JSON: {context['error']}"
        case "missing":
            return "is missing"
        case "string_pattern_mismatch" if error["loc"][-1] == "level":
            return f"must be d1, d2, …; found {_shown(found)}"
        case "string_pattern_mismatch":
            return f"letters, digits, '.', '_' and '-' only, at most 64; found {_shown(found)}"
        case "value_error":
            found_text = f"; found {_shown(found)}" if str(context["error"]).startswith("expected") else ""
            return f"{context['error']}{found_text}"
    return f"{error['msg'][0].lower()}{error['msg'][1:]}; found {_shown(found)}"


def _shown(found: Any) -> str:
    """What was found, shortened to fit into one line."""
    text = repr(found)
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}…"


def _limit(limit: float, unit: str) -> str:
    return f"{limit:g} {unit}" if unit and limit else f"{limit:g}"


def _number(found: Any) -> str:
    return f"{found:g}" if isinstance(found, float) else str(found)


def percent_hint(found: Any, most: float) -> str:
    """A share above its largest value is most often a number of percent."""
    try:
        number = float(found)
    except (TypeError, ValueError):
        return ""
    is_percent = most <= 1.0 <= number < 100.0
    return f"; write '{number:g} %' if it is in percent" if is_percent else ""


def _quoted(text: str) -> list[str]:
    return re.findall("'([^']*)'", text)
