"""What motion and recordings tell: contact forces, and the ground's friction, restitution and place."""
