"""The forms of a report, each a function from what was worked out to text or bytes."""
