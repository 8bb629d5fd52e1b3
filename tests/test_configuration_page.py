"""The page on every key of an experiment file."""

from pathlib import Path

import pytest

from hydrofdi.detectors.charts import ChartOptions, chart_kind, chart_names

PAGE = (Path(__file__).parent.parent / "docs" / "configuration.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", chart_names())
def test_every_option_of_a_chart_stands_on_the_page_with_its_default(name):
    own = PAGE.partition("## `detection.online.charts`")[2].partition("\n## ")[0]
    described = own.partition(f"\n`{name}`: ")[2].partition("\n`")[0]
    for key, info in chart_kind(name).Options.model_fields.items():
        text = own if key in ChartOptions.model_fields else described
        default = f"{info.default:g}" if isinstance(info.default, float) else f"{info.default}"
        assert f"| `{key}` | `{default}` |" in text
