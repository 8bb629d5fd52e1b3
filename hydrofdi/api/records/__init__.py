"""Whatever holds records, as sources of them."""
