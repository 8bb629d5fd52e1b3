"""Commands on simulated or measured records, and on their indicators."""
