"""What closes the loop: laws, observers, demands, monitors, and the loop itself."""
