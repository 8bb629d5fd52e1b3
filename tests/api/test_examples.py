"""The examples in docstrings, in docs/python.md and in the type-checked file run."""

import doctest
import inspect
import os
from importlib import import_module
from pathlib import Path

import pytest

import hydrofdi
from tests.api import typed_examples

ROOT = Path(__file__).parent.parent.parent

NAMED = [getattr(hydrofdi, name) for name in hydrofdi.__all__]
PUBLIC = [each for each in NAMED if inspect.isfunction(each) or ">>>" in (inspect.getdoc(each) or "")]
MODULES = sorted({each.__module__ for each in PUBLIC if each.__module__.startswith("hydrofdi.api")})


def test_every_function_of_the_api_has_an_example():
    functions = [each for each in NAMED if inspect.isfunction(each)]
    own = [each for each in functions if each.__module__.startswith("hydrofdi.api")]
    assert {each.__name__ for each in own if ">>>" not in (each.__doc__ or "")} == set()


@pytest.mark.parametrize("name", ["hydrofdi", *MODULES])
def test_the_examples_in_docstrings_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    outcome = doctest.testmod(import_module(name), optionflags=doctest.ELLIPSIS)
    assert outcome.attempted > 0
    assert outcome.failed == 0


def test_the_examples_of_the_page_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.symlink(ROOT / "configs", "configs")
    page = str(ROOT / "docs" / "python.md")
    outcome = doctest.testfile(page, module_relative=False, optionflags=doctest.ELLIPSIS, encoding="utf-8")
    assert outcome.attempted > 5
    assert outcome.failed == 0


EXAMPLES = [
    each
    for _, each in inspect.getmembers(typed_examples, inspect.isfunction)
    if each.__module__ == typed_examples.__name__
]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda each: each.__name__)
def test_a_typed_example_runs(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    example(tmp_path)


def test_the_typed_examples_are_checked():
    import tomllib

    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert "tests/api/typed_examples.py" in settings["tool"]["mypy"]["files"]
