"""How the weights of `vb-former` are learned: from simulated crowds alone, which are made while they are asked for."""
