"""From the text of blocks' methods to terms, which know no language but Python."""
