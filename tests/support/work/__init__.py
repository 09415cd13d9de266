"""Units of work for tests, and processes to kill."""
