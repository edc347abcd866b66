"""The wings of the house, their rooms, and who imports whom, from the imports themselves."""

import matplotlib.pyplot as plt

import wings

wings.draw(plt.figure(figsize=(11.5, 8.2), layout="constrained"))
