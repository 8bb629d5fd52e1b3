"""Files of indicators that extend others."""

from hydrofdi.detectors.scores.configuration import load_scores
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
