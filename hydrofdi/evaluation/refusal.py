"""Error for results that the records do not support."""

from hydrofdi.errors import ReportError


class NotStatedError(ReportError):
    """The records do not support this result.

    Parameters
    ----------
    message : str
        One sentence: what is missing, and what would help.
    records_needed : int, optional
        Number of records that would suffice, if known.
    """

    def __init__(self, message: str, records_needed: int | None = None) -> None:
        self.records_needed = records_needed
        super().__init__(message)
