"""Real rigs whose cause is known: what the diagnosis says of their loops."""
