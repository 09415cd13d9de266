"""Controllers, machines and whole loops as C99 and as FMUs, from the text that is simulated."""
