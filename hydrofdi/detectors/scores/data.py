"""Trained rules as plain data, and back; nothing in the data is executed."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, cast, get_args, get_type_hints

import numpy as np

Made = TypeVar("Made")


def plain_data(rule: Any) -> dict[str, Any]:
    """A dataclass of arrays, numbers and such dataclasses as plain data for JSON."""
    found = {field.name: getattr(rule, field.name) for field in fields(rule)}
    return {
        name: plain_data(value) if is_dataclass(value) else np.asarray(value).tolist()
        for name, value in found.items()
    }


def from_data(kind: type[Made], data: Any, where: str = "") -> Made:
    """The dataclass that plain data describe.

    Raises
    ------
    ValueError
        A key is missing or unknown, a number is not finite, or shapes do not fit; the message starts with
        the key.
    """
    hints: dict[str, Any] = get_type_hints(kind)
    if not isinstance(data, dict) or data.keys() != hints.keys():
        raise ValueError(f"{where or 'rule'}: expected the keys {', '.join(hints)}")
    made: dict[str, Any] = {}
    for name, hint in hints.items():
        path = f"{where}.{name}".strip(".")
        if is_dataclass(hint):
            made[name] = from_data(cast("type[Any]", hint), data[name], path)
            continue
        try:
            array = np.asarray(data[name])
        except ValueError:
            raise ValueError(f"{path}: expected rows of equal length") from None
        wanted = np.dtype(float) if hint is float else np.dtype(get_args(get_args(hint)[1])[0])
        if array.dtype.kind not in ("if" if wanted.kind == "f" else "i") or not np.isfinite(array).all():
            raise ValueError(f"{path}: expected finite numbers")
        if (hint is float) != (array.ndim == 0):
            raise ValueError(f"{path}: expected {'a number' if hint is float else 'a list'}")
        made[name] = float(array) if hint is float else array.astype(wanted)
    try:
        return kind(**made)
    except ValueError as error:
        raise ValueError(f"{where or 'rule'}: {error}") from None
