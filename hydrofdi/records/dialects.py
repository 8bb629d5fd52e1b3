"""Dialects of texts: what their first lines show of encoding, header, thousands, dates and units."""

from __future__ import annotations

import codecs
import gzip
import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime
from itertools import product
from pathlib import Path

from hydrofdi.errors import DataError
from hydrofdi.records import Channel
from hydrofdi.records.columns import FileColumns, channel_named
from hydrofdi.records.description import FormatConfig
from hydrofdi.records.files import open_table
from hydrofdi.records.text import TextTable, last_part
from hydrofdi.records.times import instant

_SUGGESTED = {
    Channel.CHAMBER_1_PRESSURE: "druck a, druck 1, pressure a, kammerdruck a, kammerdruck 1, pression a"
    ", pression 1",
    Channel.CHAMBER_2_PRESSURE: "druck b, druck 2, pressure b, kammerdruck b, kammerdruck 2, pression b"
    ", pression 2",
    Channel.SUPPLY_PRESSURE: "druck p, pressure p, versorgungsdruck, systemdruck, pression p",
    Channel.RETURN_PRESSURE: "druck t, pressure t, tankdruck, pression t",
    Channel.PISTON_POSITION: "weg, hub, kolbenweg, kolbenposition, course, déplacement",
    Channel.PISTON_VELOCITY: "geschwindigkeit, kolbengeschwindigkeit, vitesse",
    Channel.INPUT_VOLTAGE: "spannung, stellspannung, ventil, ventilspannung, valve, command, tension",
}
"""Names for which a description is only suggested, because they are ambiguous."""
CHANNELS = {
    name.replace(" ", ""): channel for channel, text in _SUGGESTED.items() for name in text.split(", ")
}
_LONGEST_PREAMBLE = 40
"""Lines among which the header of a text file is looked for."""
_VALUES = ("state", "value", "varvalue", "wert")
"""Names of the column of values in tables with a row for each of them."""
_THOUSANDS = {
    re.compile(rf"[-+]?\d{{1,3}}(({sign}\d{{3}})+{re.escape(decimal)}\d+|({sign}\d{{3}}){{{fewest},}})"): (
        sign[1],
        decimal,
    )
    for sign, fewest, decimals in (("[,]", 2, "."), ("[.]", 2, ","), ("[']", 1, ".,"), ("[ ]", 1, ",."))
    for decimal in decimals
}
"""Cells that have thousands → their sign and the decimal sign."""
_DATES = (
    "%d.%m.%Y %d.%m.%y %d/%m/%Y %m/%d/%Y %d/%m/%y %m/%d/%y %Y/%m/%d %Y.%m.%d %d-%m-%Y %m-%d-%Y %Y-%j"
    " %d-%b-%Y %d-%b-%y %Y%m%d"
)
_TIMES_OF_DAY = ["%H:%M:%S.%f", "%H:%M:%S,%f", "%H:%M:%S:%f", "%H:%M:%S;%f", "%H:%M:%S", "%H%M%S.%f"]
_FORMS = (
    *(
        f"{date}{sep}{time}"
        for date, sep, time in product(_DATES.split(), (" ", "T", ", ", "_", "-"), _TIMES_OF_DAY)
    ),
    *(f"{date} %I:%M:%S{more} %p" for date, more in product(reversed(_DATES.split()), (".%f", ",%f", ""))),
    *_TIMES_OF_DAY,
    "%M:%S.%f",
    "%M:%S,%f",
)
"""Formats of dates, that which the world uses before that of the USA unless it has AM and PM."""


def date_format(texts: Sequence[str]) -> tuple[str, bool] | None:
    """The format of dates, empty if it need not be stated, and whether day and month may be the other way
    round; None if it is not known."""
    with suppress(ValueError):
        for text in texts:
            instant(text)
        return "", False
    forms = [form for form in _FORMS if all(_fits(text, form) for text in texts)]
    return (forms[0], len(forms) > 1) if forms else None


def _fits(text: str, form: str) -> bool:
    with suppress(ValueError):
        return bool(datetime.strptime(text.strip(), form))
    return False


def encoding_of(file: Path) -> str:
    """The encoding of a text: UTF-8 if it is that, else that of Windows."""
    with (
        (gzip.open if file.suffix.lower() == ".gz" else open)(file, "rb") as opened,
        suppress(OSError, EOFError),
    ):
        data = opened.read(2**21)
        if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return "utf-16"
        for encoding in ("utf-8", "cp1252"):
            with suppress(UnicodeDecodeError):
                codecs.getincrementaldecoder(encoding)().decode(data)
                return encoding
        return "latin-1"
    return "utf-8"


def thousands_of(cells: Sequence[str]) -> dict[str, str]:
    """Signs of thousands and decimals, as a format states them, if cells have thousands."""
    plain = [re.sub("[\u00a0\u202f]", " ", cell.strip()) for cell in cells]
    for form, (sign, decimal) in _THOUSANDS.items():
        if any(map(form.fullmatch, plain)):
            return {"thousands": sign} | ({"decimal": ","} if decimal == "," else {})
    return {}


def long_form(table: TextTable) -> dict[str, str] | None:
    """Columns of names and values, if names of channels stand in the rows."""
    titles = table.titles
    for position in range(len(titles)):
        texts = {row[position].strip() for row in table.example if position < len(row)}
        if any(channel_named(last_part(text), "", CHANNELS) for text in texts):
            values = [title for title in titles if title.lower() in _VALUES]
            return {"name": titles[position], "value": values[0]} if values else None
    return None


def below_preamble(file: Path, encoding: str) -> tuple[int, FileColumns]:
    """Number of lines above the header, and the table: it names channels right above numbers, or most of them
    farther above, or else none."""
    candidates: list[tuple[int, int, FileColumns]] = []
    for skip in range(_LONGEST_PREAMBLE):
        with (
            suppress(DataError),
            open_table(file, str(file), FormatConfig(skip=skip, encoding=encoding)) as table,
        ):
            if not isinstance(table, TextTable):
                return skip, table
            titles = enumerate(table.titles if table.has_numbers else ())
            n_named = sum(channel_named(title, table.unit(n), CHANNELS) is not None for n, title in titles)
            if n_named and not table.n_between and table.first_numeric:
                return skip, table
            candidates += [(n_named, -skip, table)] * table.has_numbers
    if candidates:
        _, skip, table = max(candidates, key=lambda candidate: candidate[:2])
        return -skip, table
    with open_table(file, str(file), FormatConfig(encoding=encoding)) as table:
        return 0, table
