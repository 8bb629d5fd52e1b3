"""The optional extra that most scores need for training."""

from collections.abc import Iterator
from contextlib import contextmanager

from hydrofdi.errors import ConfigError

EXTRA = "pip install 'hydrofdi[learn]'"
"""Command that installs the extra."""


def has_extra() -> bool:
    """Whether the extra is installed."""
    try:
        with scikit_learn(""):
            return True
    except ConfigError:
        return False


@contextmanager
def scikit_learn(name: str) -> Iterator[None]:
    """Context for the use of scikit-learn by a score, including imports.

    Its linear algebra runs in one thread: then results do not depend on the number of cores, and
    oversubscribed threads do not slow it down twentyfold.

    Parameters
    ----------
    name : str
        Name of the score.

    Raises
    ------
    ConfigError
        scikit-learn is not installed.
    """
    try:
        import sklearn  # noqa: F401
        from threadpoolctl import threadpool_limits
    except ModuleNotFoundError as error:
        if error.name not in ("sklearn", "threadpoolctl"):
            raise
        raise ConfigError(f"the score {name} needs the extra: {EXTRA}") from None
    with threadpool_limits(limits=1):
        yield
