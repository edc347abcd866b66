"""Print the memory that a solve needs, over the grid."""

from roughcontact.contact import checks

print("points            double    single")
for points in (1024, 2048, 4096, 8192, 16384):
    double, single = (
        checks.memory_estimate((points, points), precision=precision) / 2**30
        for precision in ("double", "single")
    )
    print(f"{points:6d} × {points:<6d} {double:6.2f}    {single:6.2f} GiB")
