"""Rejection of a file, or of a part of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hydrofdi.errors import DataError, Issue


class RejectionError(Exception):
    """No record can be formed; it is listed with the reason, and the other records continue.

    Attributes
    ----------
    remark : Issue
    """

    def __init__(self, kind: str, text: str) -> None:
        self.remark = Issue(text, kind=kind, is_unusable=True)
        super().__init__(text)


@contextmanager
def damage_named(what: str) -> Iterator[None]:
    """Turn whatever a library raises on a broken file into `RejectionError`."""
    try:
        yield
    except (DataError, RejectionError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise RejectionError("damaged", f"cannot be read as {what}: {reason}") from None
