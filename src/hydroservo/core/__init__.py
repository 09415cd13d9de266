"""What every block and every result is made of: blocks, roles, signals, units, errors."""
