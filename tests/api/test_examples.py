"""The examples in docstrings and of docs/python.md run."""

import doctest
import inspect
import os
from importlib import import_module
from pathlib import Path

import pytest

import hydrofdi

ROOT = Path(__file__).parent.parent.parent

NAMED = [getattr(hydrofdi, name) for name in hydrofdi.__all__]
PUBLIC = [each for each in NAMED if inspect.isfunction(each) or ">>>" in (inspect.getdoc(each) or "")]
MODULES = sorted({each.__module__ for each in PUBLIC if each.__module__.startswith("hydrofdi.api")})


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
