"""Records in files that other programs read, and hydrofdi reads again without a description."""
