"""What a study says of estimates whose truth is known."""
