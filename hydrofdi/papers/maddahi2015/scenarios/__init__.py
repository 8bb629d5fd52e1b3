"""Claims and controls over scenarios: what the paper leaves open."""
