"""Which fault changed a machine: hypotheses about the unknowns of its volume balance."""
