"""What the paper's supplement asks of a data set: sweeps over drops, ablations, a user study."""
