"""The examples in docstrings and of docs/python.md run."""

import doctest
import inspect
import os
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from mypy import api as mypy

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


def test_an_export_is_told_in_few_words(tmp_path):
    done = hydrofdi.export(np.ones((2, 99)) * 5e6, tmp_path / "out", sampling_frequency="1 kHz")
    assert repr(done).startswith("2 files in ")


def _examples():
    named = [getattr(hydrofdi, name) for name in hydrofdi.__all__]
    yield "page", (ROOT / "docs" / "python.md").read_text()
    yield from ((each.__name__, text) for each in named if ">>>" in (text := inspect.getdoc(each) or ""))


def test_the_examples_of_page_and_docstrings_have_right_types(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    parser, blocks = doctest.DocTestParser(), []
    for name, text in _examples():
        lines = "".join(each.source for each in parser.get_examples(text)).splitlines()
        blocks.append("\n    ".join([f"def example_{name}() -> None:", *lines]))
    file = tmp_path / "examples.py"
    file.write_text("\n\n".join(blocks) + "\n")
    told, errors, code = mypy.run(["--strict", "--config-file", "pyproject.toml", str(file)])
    assert code == 0, told + errors
