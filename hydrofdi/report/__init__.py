"""Tables, sections and figures made from experiments."""
