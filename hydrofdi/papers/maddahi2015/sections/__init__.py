"""The sections of the study, each made from what was computed."""
