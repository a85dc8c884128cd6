"""How the network runs: written down once as steps of one kernel."""
