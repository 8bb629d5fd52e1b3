"""The ``limits`` section: limits of a run."""

from __future__ import annotations

from typing import Annotated

from hydrofdi.settings.quantities import SI, Section


class LimitsConfig(Section):
    """Limits that end a run when exceeded."""

    time_per_job: Annotated[float, SI("s", above=0)] | None = None
    """Wall time allowed for one run [s]; a run that takes longer is stored with status ``timeout``."""
