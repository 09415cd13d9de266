"""How fast hydroservo is, and how fast its peers are at the same work."""
