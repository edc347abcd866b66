"""Figure of the layers of the package, their modules and the imports between them."""

import matplotlib.pyplot as plt

import api_pages

api_pages.draw_layers(plt.figure(figsize=(11.5, 8.2), layout="constrained"))
