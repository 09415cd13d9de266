"""What exported C costs on a processor, measured with the tools that its users have."""
