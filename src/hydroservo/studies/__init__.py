"""Laws held against each other under many conditions: what is asked, what was found, what it says."""
