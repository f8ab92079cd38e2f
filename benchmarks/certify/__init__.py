"""How well certificates of motions find what was spoilt, beside kinematic filters."""
