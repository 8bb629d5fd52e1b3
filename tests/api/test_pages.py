"""What notebooks show of results, and the types of the examples."""

import doctest
import inspect
from pathlib import Path

import numpy as np
from mypy import api as mypy

import hydrofdi

ROOT = Path(__file__).parent.parent.parent


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
