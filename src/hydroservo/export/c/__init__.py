"""From terms to C99: its text, its test vectors, its folder, its compiler."""
