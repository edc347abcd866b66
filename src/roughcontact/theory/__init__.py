"""Closed forms: Hertz, waves, indenters, and the theory of Persson."""
