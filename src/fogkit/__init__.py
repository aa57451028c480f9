"""fogkit."""
