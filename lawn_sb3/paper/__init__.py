"""What the paper prints, what its figures identify, and what it claims."""
