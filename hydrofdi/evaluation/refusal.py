"""What is not stated because the records do not carry it."""

from hydrofdi.errors import ReportError


class NotStatedError(ReportError):
    """A number that these records do not allow to state.

    Parameters
    ----------
    message : str
        One sentence: what is missing, what would help.
    records_needed : int, optional
        How many records would do, where that is known.
    """

    def __init__(self, message: str, records_needed: int | None = None) -> None:
        self.records_needed = records_needed
        super().__init__(message)
