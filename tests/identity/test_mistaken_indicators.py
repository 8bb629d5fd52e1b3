"""Choices of indicators that are mistaken: each is one line with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from hydrofdi.config import ExperimentConfig, load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.selection import TAKEN
from hydrofdi.store.layout import names


def loaded(folder: Path, indicators: str) -> ExperimentConfig:
    file = folder / "file.yaml"
    file.write_text(f"name: chosen\nindicators: {indicators}\n")
    return load_experiment(file)


@pytest.mark.parametrize(
    "text",
    [
        "true", "3", "null", "[]", "{}", '"*"', "'dwt,,modwt'", "[dwt, {modwt: {levels: 3}}]", "[dwt, 3]",
        "[dwt, dwt]", "[dwt, all]", "{rod: {}}", "{dwt: 3}",
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(tmp_path: Path, text: str) -> None:
    with pytest.raises(ConfigError) as error:
        loaded(tmp_path, text)
    (line,) = str(error.value).splitlines()
    assert line.startswith(f"{tmp_path}/file.yaml:2: indicators")


@pytest.mark.parametrize(
    "label",
    ["a.b/c d", "../x", "", "dwt.d1", "<b>", "run", "phase", "3", "-a", "ä", "a\n", "x" * 65],
)
def test_a_label_that_a_file_cannot_hold_is_a_mistake(label: str) -> None:
    with pytest.raises(ConfigError) as error:
        make_indicators({label: {"kind": "dwt"}})
    assert len(error.value.mistakes) == 1
    make_indicators({"fine-Label_2": {"kind": "dwt"}})


def test_no_label_is_the_name_of_a_variable_of_a_file() -> None:
    variables = (
        *names.REQUESTED,
        names.REPLICATED,
        *names.BY_LEVEL,
        *names.stored_variables("all", phases=True),
    )
    dimensions = {names.RUN, names.TIME, names.LEVEL, names.PHASE}
    assert {variable.name for variable in variables} | dimensions == TAKEN
