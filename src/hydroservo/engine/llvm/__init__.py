"""From terms to the text of LLVM."""
