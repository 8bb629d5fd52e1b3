"""Figure 2: signals of the normal and of the leaky actuator side by side."""

from __future__ import annotations

from matplotlib.figure import Figure

from hydrofdi.papers.maddahi2015.figures.choice import run_position, shown_leakage
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures.signals import (
    PANELS,
    draw_panels,
    draw_reference,
    panel_labels,
    panel_lines,
    stroke_axes,
)
from hydrofdi.report.figures.style import BLUE, INK, ORANGE
from hydrofdi.report.wording import mode_name
from hydrofdi.store.layout import names


def draw_figure_2(study: Study) -> Figure:
    """Figure 2: (a) normal and (b) with the small leakage, both at the normal EBM."""
    grid, wavelet = study.grid, study.data.experiment.wavelet
    titles, columns, references = [], [], []
    for letter, leakage in zip("ab", dict.fromkeys((0, shown_leakage(study))), strict=False):
        position = run_position(study, leakage, grid.normal)
        signals = {name: study.data.signal(name, position) for name, _, _ in PANELS}
        columns.append(panel_lines(PANELS, signals, wavelet))
        is_closed = study.data.values("control.law")[position] != "open"
        shown = study.data.signal(names.REFERENCE_POSITION, position) if is_closed else None
        references.append(shown)
        flow = grid.leakage_flows[leakage - 1] if leakage else 0.0
        titles.append(f"({letter}) {mode_name(flow, grid.bulk_moduli[grid.normal])}")
    figure = draw_panels(columns, titles, [BLUE, ORANGE], panel_labels(PANELS, wavelet))
    for axis, shown in zip(stroke_axes(figure, len(references)), references, strict=True):
        if shown is not None:
            draw_reference(axis, *shown, INK)
    return figure
