"""A report as LaTeX tables for the package booktabs."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.report.document import Cell, Document, Sheet

_LEFT_OUT = ("provenance", "signals")
"""Sections that are left out of LaTeX."""

_ESCAPES = {
    "\\": r"\textbackslash{}", "%": r"\%", "_": r"\_", "&": r"\&", "#": r"\#", "$": r"\$",
    "{": r"\{", "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": "$<$", ">": "$>$",
    "|": r"\textbar{}", "δ": r"$\delta$", "β": r"$\beta$", "ζ": r"$\zeta$", "µ": r"$\mu$", "μ": r"$\mu$",
    "·": r"$\cdot$", "–": "--", "…": r"\dots{}", "±": r"$\pm$", "′": "$'$", "²": r"$^{2}$", "³": r"$^{3}$",
    "√": r"$\surd$", "×": r"$\times$", "≥": r"$\ge$", "≤": r"$\le$", "→": r"$\to$", "−": "$-$",
    "↑": r"$\uparrow$", "↓": r"$\downarrow$", "↕": r"$\updownarrow$",
    "°": r"$^{\circ}$", "\N{NO-BREAK SPACE}": "~",
}  # fmt: skip


def render_latex(document: Document) -> str:
    """The tables of a report; ``\\input`` them into a document with ``\\usepackage{booktabs}``."""
    lines = [f"% {document.title}: made by hydrofdi; needs \\usepackage{{booktabs}}", ""]
    for block in document.blocks:
        if block.key in _LEFT_OUT:
            continue
        for sheet in block.shown_sheets:
            lines += [*_sheet_lines(block.title, sheet), ""]
    return "\n".join(lines)


def _sheet_lines(title: str, sheet: Sheet) -> Iterator[str]:
    yield r"\begin{table}"
    yield rf"\caption{{{_escaped(title)}. {_escaped(sheet.title)}.}}"
    yield rf"\label{{tab:{sheet.key}}}"
    yield r"\centering\footnotesize"
    yield rf"\begin{{tabular}}{{{_columns(sheet)}}}"
    yield r"\toprule"
    yield " & ".join(_escaped(header) for header in sheet.headers) + r" \\"
    yield r"\midrule"
    for position, row in enumerate(sheet.rows):
        if position in sheet.breaks:
            yield r"\addlinespace"
        yield " & ".join(_cell(cell) for cell in row) + r" \\"
    yield r"\bottomrule"
    yield r"\end{tabular}"
    if sheet.note:
        yield rf"\par\smallskip {_escaped(sheet.note)}"
    yield r"\end{table}"


def _columns(sheet: Sheet) -> str:
    return "".join("l" if column in sheet.text_columns else "r" for column in range(len(sheet.headers)))


def _cell(cell: Cell) -> str:
    text = cell.text
    is_signed = text[:1] == "+" and text[1:2].isdigit()
    text = f"${text[0]}${_escaped(text[1:])}" if is_signed else _escaped(text)
    return rf"\textbf{{{text}}}" if cell.is_strong else text


def _escaped(text: str) -> str:
    return "".join(_ESCAPES.get(character, character) for character in text)
