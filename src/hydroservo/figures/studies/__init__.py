"""Pictures of a study: laws held against each other under many conditions."""
