"""Parts of settings files: YAML with line numbers, quantities with units, strict sections."""
