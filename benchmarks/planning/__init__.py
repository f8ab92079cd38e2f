"""What planning through contact costs, and what the contact-implicit controller does in a loop."""
