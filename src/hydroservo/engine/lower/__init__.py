"""Functions of plain Python on numbers, blocks and arrays as the text of one LLVM function."""
