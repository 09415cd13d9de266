"""The report on the study: figures, pictures of the verdicts, data, and one page that shows them all."""
