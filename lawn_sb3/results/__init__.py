"""Reading back what runs left, and the statistics over it."""
