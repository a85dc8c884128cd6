"""The descent: people eliminated, Gauss–Newton on the poses, covariances, and what is kept of frames that leave."""
