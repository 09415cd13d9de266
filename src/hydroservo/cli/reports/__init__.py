"""What each command leaves in its folder: its own files, and what its report says."""
