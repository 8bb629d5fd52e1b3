"""The forms of a report, each a function from what was computed to text or bytes."""
