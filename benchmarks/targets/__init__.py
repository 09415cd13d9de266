"""What exported controllers cost on a processor, as tables."""
