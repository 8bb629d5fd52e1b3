"""Choices of indicators that are mistaken: each is one line with its place."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hydrofdi.config import ExperimentConfig, load_experiment
from hydrofdi.config.schema import experiment_schema
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import indicator_names, load_indicators, make_indicators
from hydrofdi.indicators.labels import TAKEN
from hydrofdi.store.layout import names


def loaded(folder: Path, indicators: str) -> ExperimentConfig:
    file = folder / "file.yaml"
    file.write_text(f"name: chosen\nindicators: {indicators}\n")
    return load_experiment(file)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("true", "expected 'all', names, or"),
        ("3", "expected 'all', names, or"),
        ("null", "expected 'all', names, or"),
        ("[]", "expected 'all', names, or"),
        ("{}", "expected 'all', names, or"),
        ('"*"', "there is no indicator '*'"),
        ("'dwt,,modwt'", "expected 'all', names, or"),
        ("[dwt, {modwt: {levels: 3}}]", "write 'indicators: {dwt: {}, modwt: {levels: 3}}'"),
        ("[dwt, 3]", "expected the name of an indicator; found 3"),
        ("[dwt, dwt]", "'dwt' is named twice"),
        ("[dwt, all]", "'all' cannot be combined"),
        ("{rod: {}}", "add 'kind: NAME'"),
        ("{dwt: 3}", "expected 'option: value' pairs"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(ConfigError) as error:
        loaded(tmp_path, text)
    (line,) = str(error.value).splitlines()
    assert line.startswith(f"{tmp_path}/file.yaml:2: indicators")
    assert sentence in line


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


def test_all_and_one_name_are_what_they_are_for_measure(tmp_path: Path) -> None:
    assert list(loaded(tmp_path, "all").indicators) == indicator_names()
    assert loaded(tmp_path, "modwt").indicators == {"modwt": {}}
    assert list(load_experiment(settings=["indicators=all"]).indicators) == indicator_names()


@pytest.mark.parametrize("text", ["dwt,,modwt", "dwt,dwt", "", ","])
def test_the_option_of_measure_has_the_same_mistakes(text: str) -> None:
    with pytest.raises(ConfigError, match=r"expected 'all'|named twice"):
        load_indicators(text)


def test_the_schema_knows_all_forms() -> None:
    text, several, labelled = experiment_schema()["properties"]["indicators"]["anyOf"]
    assert (text["type"], several["type"], labelled["type"]) == ("string", "array", "object")
    assert re.fullmatch(labelled["propertyNames"]["pattern"], "a.b") is None
    assert "run" in labelled["propertyNames"]["not"]["enum"]
