"""The extra that most scores need."""

from collections.abc import Iterator
from contextlib import contextmanager

from hydrofdi.errors import ConfigError


@contextmanager
def needing_extra(name: str) -> Iterator[None]:
    """Surrounds imports of scikit-learn by a score.

    Raises
    ------
    ConfigError
        It is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name and error.name.partition(".")[0] == "sklearn":
            raise ConfigError(f"the score {name} needs the extra: pip install 'hydrofdi[learn]'") from None
        raise
