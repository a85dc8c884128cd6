"""`vb-former`: a recurrent attention network that weights the residuals of a Gauss–Newton pose fit."""
