"""Time of one solve and of other programs, from benchmarks/peers.json."""

import matplotlib.pyplot as plt

import measuring
import peers

figure = plt.figure(figsize=(9, 4), layout="constrained")
peers.plot(measuring.read_rows(peers.STORED), figure)
