"""Objects with records, as sources."""
