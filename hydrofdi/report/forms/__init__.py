"""The forms of a report, each a function from computed results to text or bytes."""
