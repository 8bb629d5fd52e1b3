"""Files of indicators that extend others."""

import pytest

from hydrofdi.config.study.scores import load_scores
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import load_indicators

ONE = "indicators:\n  one: {kind: dwt, levels: 3}\nscores:\n  s: {kind: mahalanobis, of: [one.d1, one.d2]}\n"
TWO = "indicators: {two: {kind: modwt}}\n"


def test_files_of_indicators_are_combined(tmp_path):
    (tmp_path / "one.yaml").write_text(ONE)
    (tmp_path / "two.yaml").write_text(TWO)
    both = tmp_path / "both.yaml"
    both.write_text("extends: [one.yaml, two.yaml]\n")
    chosen = load_indicators(str(both))
    assert {label: each.name for label, each in chosen.items()} == {"one": "dwt", "two": "modwt"}
    assert list(load_scores(str(both), chosen)) == ["s"]
    both.write_text("extends: one.yaml\nindicators: {one: {levels: 4}}\n")
    (one,) = load_indicators(str(both)).values()
    assert (one.name, one.options.levels) == ("dwt", 4)


def test_a_mistake_is_told_with_the_file_that_holds_it(tmp_path):
    (tmp_path / "one.yaml").write_text(ONE.replace("levels", "level"))
    over = tmp_path / "over.yaml"
    over.write_text("extends: one.yaml\n")
    with pytest.raises(ConfigError, match=r"one\.yaml:2"):
        load_indicators(str(over))
    over.write_text("extends: over.yaml\n")
    with pytest.raises(ConfigError, match="extend each other"):
        load_indicators(str(over))
