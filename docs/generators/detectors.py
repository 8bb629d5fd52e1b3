"""The page of all detectors and control charts, with their presets."""

from __future__ import annotations

from pathlib import Path

from generators.writing import table, write_page
from hydrofdi.detectors.rules import chart_kind, chart_names
from hydrofdi.indicators.registry import describe
from hydrofdi.settings.files import ready_folder, ready_names

INTRODUCTION = """\
# Detectors and charts

A detector that knows a model is an indicator: `hydrofdi measure rig.csv --indicators detectors/weak-rls`.
[Detectors that know a model](../detectors.md) explains what each finds, needs and cannot do. A preset is
a file with every number written out: copy it, and fill in your data sheet.
"""

CHARTS = """\
## Control charts

A chart turns the numbers of a detector into alarms, on line. Their options:
[`detection.online.charts`](configuration.md#detectiononlinecharts).
"""


def write(reference: Path) -> None:
    """Write ``reference/detectors.md``."""
    charts = [(f"`{name}`", chart_kind(name).summary, chart_kind(name).caution) for name in chart_names()]
    parts = [
        INTRODUCTION,
        table(("detector", "what it tells", "channels", "presets"), _rows()),
        "",
        CHARTS,
        table(("chart", "what it does", "caution"), charts),
    ]
    write_page(reference / "detectors.md", "\n".join(parts) + "\n")


def _rows() -> list[tuple[str, ...]]:
    presets = [name for name in ready_names() if name.startswith("detectors/")]
    kinds: dict[str, list[str]] = {}
    for preset in presets:
        kinds.setdefault(_kind(preset), []).append(preset)
    return [_row(kind, own) for kind, own in kinds.items()]


def _kind(preset: str) -> str:
    text = (ready_folder() / f"{preset}.yaml").read_text(encoding="utf-8")
    return text.partition("kind: ")[2].partition("\n")[0].partition("#")[0].strip()


def _row(kind: str, presets: list[str]) -> tuple[str, ...]:
    described = describe(kind)
    links = ", ".join(f"[`{preset}`](configurations/{preset}.md)" for preset in presets)
    channels = ", ".join(f"`{channel}`" for channel in described.channels)
    return f"[`{kind}`](indicators.md#{kind})", described.summary, channels, links
