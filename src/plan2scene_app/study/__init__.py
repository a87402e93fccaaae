"""Studies of the method: plots, sweeps over drops, ablations, and the user study."""
