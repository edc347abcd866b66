"""Joints of solved contacts: interface law, conductance, leakage, and estimates."""
