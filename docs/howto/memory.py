"""Print the memory that a solve needs, over the grid and the part of it that touches."""

from roughcontact.contact.memory import MemoryNeed

PARTS = (0.01, 0.1, 1.0)

print(
    "points           ", *(f"{100 * part:5.0f} %" for part in PARTS), "   1 % in single precision"
)
for points in (1024, 2048, 4096, 8192, 16384):
    double = [MemoryNeed((points, points)).estimate(part) / 2**30 for part in PARTS]
    single = MemoryNeed((points, points), precision="single").estimate(0.01)
    print(
        f"{points:6d} × {points:<6d}  ",
        *(f"{size:7.2f}" for size in double),
        f"{single / 2**30:9.2f} GiB",
    )
