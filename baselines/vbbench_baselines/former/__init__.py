"""`vb-former`: a recurrent network of attention that corrects, weighs and forgets, about a pose fit in closed steps."""
