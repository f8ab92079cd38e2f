"""Which law was broken, where and by how much; never imports a solver."""
