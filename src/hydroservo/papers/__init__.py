"""Published studies, reproduced and judged: one sourced parameter set and its claims per paper."""
