"""Records of any source as files of other programs."""
