"""Published studies, reproduced and judged: all of a paper in one folder, and none of it elsewhere."""
