"""Messages from Python name keywords, the parts of data by their place, and the keys of a section."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import hydrofdi
from hydrofdi.cli.app import application
from hydrofdi.quality.failures import FAILURES, remedy
from hydrofdi.settings.file_kinds import USE
from hydrofdi.settings.naming import ONLY_COMMANDS, command, settings_as_options

PACKAGE = Path(hydrofdi.__file__).parent
OPTION = re.compile(r"(?<![-\w])--[a-z][a-z-]+")
SPELT_OUT = re.compile(r"'hydrofdi [a-z]")

NOT_MESSAGES = {
    "settings/naming.py": "the names of options themselves",
    "store/folder/provenance.py": "options of git",
    "report/publication.py": "variables of a style sheet",
}
"""Modules whose texts have two hyphens in front of a word for another reason."""


def _texts(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Texts of a module, except its docstrings, with their lines."""
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in alone:
            yield node.lineno, node.value


@pytest.mark.parametrize("pattern", [OPTION, SPELT_OUT])
def test_no_message_below_the_commands_names_an_option_or_spells_out_a_command(pattern):
    found = [
        f"{file.relative_to(PACKAGE)}:{line}: {text}"
        for file in sorted(PACKAGE.rglob("*.py"))
        if not file.is_relative_to(PACKAGE / "cli") and str(file.relative_to(PACKAGE)) not in NOT_MESSAGES
        for line, text in _texts(ast.parse(file.read_text()))
        if pattern.search(text)
    ]
    assert found == []


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"engine": "dask"}, "the engine dask needs scheduler='tcp://host:port'"),
        ({"scheduler": "tcp://host:8786"}, "scheduler and shared_directory need engine='dask'"),
    ],
)
def test_a_choice_of_engine_is_refused_by_its_keywords(settings, named, tmp_path):
    with pytest.raises(hydrofdi.HydrofdiError, match=re.escape(named)):
        hydrofdi.sweep({"name": "asked"}, out=tmp_path / "asked", **settings)


@pytest.mark.parametrize("status", FAILURES)
def test_a_remedy_names_keywords_or_options(status):
    told = remedy(status)
    with settings_as_options():
        options = remedy(status).replace("--retry-failed", "retry_failed").replace("--workers", "workers")
    assert re.sub(r"'hydrofdi (\w+)'", r"hydrofdi.\1(…)", options) == told
    assert "--" not in told


def _named_commands(tree: ast.AST) -> Iterator[str]:
    """First words of the commands that a module names in messages."""
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Name(id="command"), args=[ast.Constant(value=str(text)), *_]):
                yield text.partition(" ")[0]


def test_every_named_command_exists_on_the_command_line_and_in_python():
    named = {use.partition(" ")[0] for use, _ in USE.values()}
    for file in PACKAGE.rglob("*.py"):
        if not file.is_relative_to(PACKAGE / "cli"):
            named |= {*_named_commands(ast.parse(file.read_text()))}
    known = {each.callback.__name__ for each in application().registered_commands}
    functions = {re.fullmatch(r"hydrofdi\.(\w+)\(…\)", command(name))[1] for name in named - ONLY_COMMANDS}
    assert len(named) > 10
    assert named | ONLY_COMMANDS <= known
    assert functions <= {*hydrofdi.__all__}
    assert not ONLY_COMMANDS & {*hydrofdi.__all__}


def test_each_of_several_frames_is_named_by_its_place():
    frames = [pd.DataFrame({"P1 [bar]": [50.0, 51.0]}), pd.DataFrame({"torque [N·m]": [1.0, 2.0]})]
    with pytest.raises(hydrofdi.HydrofdiError, match=r"^DataFrame 2: no column is named like a channel"):
        hydrofdi.measure(frames, sampling_frequency="1 kHz")


def test_each_of_several_arrays_is_named_by_its_place():
    arrays = [np.zeros(100), np.zeros((2, 2, 100))]
    with pytest.raises(hydrofdi.HydrofdiError, match=r"^array 2: has 3 dimensions"):
        hydrofdi.measure(arrays, sampling_frequency="1 kHz")


def test_few_records_of_several_frames_are_told_with_each_name():
    frame = pd.DataFrame({"P1 [Pa]": 5e6 + 1e4 * np.random.default_rng(1).standard_normal(1000)})
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        hydrofdi.train([frame] * 3, output="d2", sampling_frequency="1 kHz", direction="both")
    assert "the DataFrame" not in str(refused.value)


@pytest.mark.parametrize(
    ("stated", "hint"),
    [
        ({"window": "2 s"}, "write window: {duration: 2 s}"),
        ({"window": 2}, "found 2; its keys are by, duration, every, channel, edge"),
    ],
)
def test_a_value_for_a_section_is_refused_with_its_keys(stated, hint):
    records = np.random.default_rng(1).standard_normal((4, 1000))
    with pytest.raises(hydrofdi.HydrofdiError, match=re.escape(hint)):
        hydrofdi.train(records, config=stated, sampling_frequency="1 kHz")
