# %% [markdown]
# # Speed against error
#
# A ball slides over a box, 1 mm deep, and should feel 1 N upwards. Contact with the box uses either spheres, whose bumps
# become smaller as their number grows, or its mesh. The mesh's error is the separation that contact keeps between
# meshes: 1 µm, which at 1 N/mm is 1 mN.

# %%
import time

import matplotlib.pyplot as plt
import numpy
import palpate

SIDE, RADIUS, DEPTH, TRUTH = 0.04, 0.004, 0.001, numpy.array([0, 1, 0])
ball = palpate.ball("ball", RADIUS)
path = numpy.zeros((2000, 3))
path[:, 0] = numpy.linspace(-0.018, 0.018, len(path))
path[:, 1] = SIDE / 2 + RADIUS - DEPTH
path[:, 2] = numpy.linspace(-0.015, 0.015, len(path))


def measure(contact, leaves):
    """Microseconds of a step, the best of five runs, for a machine has other work, too; and the mean error in mN."""
    box = palpate.body("box", *palpate.box([SIDE] * 3), contact=contact, leaves=leaves)
    proxy = palpate.Proxy(palpate.Model([box], ball, contact=contact), path[0])
    taken = []
    for _ in range(5):
        proxy.restart(path[0])
        began = time.perf_counter()
        force = proxy.steps(path).wrench[:, :3]
        taken.append(time.perf_counter() - began)
    return 1e6 * min(taken) / len(path), 1e3 * numpy.linalg.norm(force - TRUTH, axis=1).mean()


spheres = {leaves: measure("spheres", leaves) for leaves in (64, 128, 256, 512, 1024)}
by_mesh = measure("surface", 32)

# %%
figure, axes = plt.subplots(figsize=(7, 4.5))
axes.semilogy(*zip(*spheres.values()), "o", label="by so many spheres")
for leaves, at in spheres.items():
    axes.annotate(f"{leaves}", at, xytext=(5, 5), textcoords="offset points")
axes.semilogy(*by_mesh, "s", label="by its mesh")
axes.set_xlim(left=0)
axes.margins(0.12)
axes.set_xlabel("time of a step in µs")
axes.set_ylabel("mean error of a force of 1 N, in mN")
axes.legend()
figure.tight_layout()
for name, (us, error) in {**spheres, "mesh": by_mesh}.items():
    print(f"{name:>5} {us:6.2f} µs {error:7.1f} mN")

# %% [markdown]
# Times depend on the machine that ran this; errors are the same everywhere.

# %%
errors = [error for _, error in spheres.values()]
assert errors == sorted(errors, reverse=True)
assert by_mesh[1] < 1.1
