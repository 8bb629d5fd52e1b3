"""Control charts, one module each."""
