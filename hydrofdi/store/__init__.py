"""Storage of results: shards written by workers, and the experiment file built from them."""
