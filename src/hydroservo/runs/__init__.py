"""Run loops: one, many at once, a search for gains; and what comes out of them."""
