"""Terms of rewards and costs about contact, for whoever trains a policy."""
