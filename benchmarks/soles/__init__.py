"""The exact cone of a sole against Clarabel and 50 digits, and what its questions cost."""
