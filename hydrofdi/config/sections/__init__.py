"""The sections of one run: plant, drive, sensors and record."""
