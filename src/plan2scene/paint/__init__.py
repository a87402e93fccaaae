"""Paint and light of a house: what photos show is paint times light times exposure."""
