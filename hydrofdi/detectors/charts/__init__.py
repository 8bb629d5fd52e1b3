"""Control charts: what is asked of a score along the time."""
