"""What files of settings are made of: YAML with its lines, quantities with units, strict sections."""
