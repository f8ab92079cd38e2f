"""Which law was broken, where and by how much; never imports a solver."""

from surefoot.audit.laws import Laws, check_laws, contact_use

__all__ = ["Laws", "check_laws", "contact_use"]
