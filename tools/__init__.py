"""What tests, benchmarks and the documentation share, and no user needs."""
