"""What a command found, as a page that opens offline, tables for a paper and figures for a journal."""
