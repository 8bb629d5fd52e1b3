import pytest

from tests.report.detection.made_up import judged


@pytest.fixture(scope="package")
def detection():
    """Seven scores of 1,520 records."""
    return judged()
