"""docs/equations.md is held to its word: every number of it is what the code returns."""

import ast
import csv
import importlib
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


def _table(name: str) -> list[list[str]]:
    """Rows of a table that docs/equations.md shows, without its header."""
    with (ROOT / "docs" / "tables" / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))[1:]


EQUATIONS = _table("equations")
NOTES = (ROOT / "docs" / "equations.md").read_text(encoding="utf-8")
ROWS = [(identifier, call.strip("`"), value) for identifier, call, value, _ in _table("equation-numbers")]


def _function(dotted: str) -> Any:
    module, _, name = dotted.rpartition(".")
    return getattr(importlib.import_module(f"hydrofdi.{module}"), name)


def _evaluate(text: str) -> float:
    expression = ast.parse(text, mode="eval").body
    item = None
    if isinstance(expression, ast.Subscript):
        expression, item = expression.value, ast.literal_eval(expression.slice)
    assert isinstance(expression, ast.Call)
    arguments = {str(part.arg): ast.literal_eval(part.value) for part in expression.keywords}
    arguments |= {name: SimpleNamespace(**of) for name, of in arguments.items() if isinstance(of, dict)}
    result = _function(ast.unparse(expression.func))(**arguments)
    return float(np.real(result if item is None else result[item]))


@pytest.mark.parametrize(("identifier", "call", "value"), ROWS, ids=[row[0] for row in ROWS])
def test_function_returns_the_number_in_the_document(identifier: str, call: str, value: str) -> None:
    assert _evaluate(call) == pytest.approx(float(value), rel=2e-9, abs=1e-30)


UNNUMBERED = {"1", "3", "10", "u1", "u2", "u4", "m10"}
"""Derivatives by name, the twin of 9, signals, what takes a section or an autocovariance, lags in series."""


def test_every_equation_has_a_number() -> None:
    identifiers = {part for row in EQUATIONS for part in row[0].split(", ")}
    assert identifiers <= {row[0].strip() for row in ROWS} | UNNUMBERED


def test_every_equation_names_a_test_that_exists() -> None:
    for row in EQUATIONS:
        for file in re.findall(r"`([^`]+\.py)`", row[4]):
            assert (ROOT / "tests" / file).is_file(), f"equation {row[0]}"


def test_every_physics_function_stands_in_the_document() -> None:
    silent = {  # how, not what
        "decaying_exponential", "signed_root", "equation", "settled", "stribeck_force", "laws_that_use",
    }  # fmt: skip
    text = NOTES + "\n".join(row[3] for row in EQUATIONS)
    for file in (ROOT / "hydrofdi" / "physics").glob("*.py"):
        functions = re.findall(r"^def ([a-z]\w+)", file.read_text(encoding="utf-8"), re.MULTILINE)
        for name in set(functions) - silent:
            assert re.search(rf"\b{name}\b", text), f"{file.stem}.{name} is not in docs/equations.md"
