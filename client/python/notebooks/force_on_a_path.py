# %% [markdown]
# # Force on a path, against the truth
#
# A ball is drawn across an egg, an ellipsoid of revolution, without friction. The tool rests at the point outside the
# egg that is nearest to the hand, and a spring of 1 N/mm pulls the hand there. So the true force is 1 N/mm times the
# depth of the hand's ball, along the normal of the ellipsoid; depth and normal follow from the point of the ellipsoid
# that is nearest to the hand.

# %%
import matplotlib.pyplot as plt
import numpy
import palpate

AXES, RADIUS, STIFFNESS = numpy.array([0.03, 0.02, 0.02]), 0.004, 1000.0

egg = palpate.body("egg", *palpate.ellipsoid(AXES, triangles=20_000))
model = palpate.Model([egg], palpate.ball("ball", RADIUS), stiffness_N_per_m=STIFFNESS)
path = numpy.zeros((4000, 3))
path[:, 0] = numpy.linspace(-0.03, 0.03, len(path))
path[:, 1] = 0.0215
path[:, 2] = 0.005
felt = palpate.Proxy(model, path[0]).steps(path)
felt

# %% [markdown]
# The nearest point is $q = a^2 p / (a^2 + t)$ for the $t$ at which $q$ lies on the ellipsoid (Eberly, *Distance from a
# point to an ellipsoid*); bisection finds it, for all poses at once.

# %%
low, high = numpy.full(len(path), -0.9 * AXES.min() ** 2), numpy.full(len(path), 1.0)
for _ in range(100):
    t = (low + high) / 2
    outside = ((AXES * path / (AXES**2 + t[:, None])) ** 2).sum(axis=1) > 1
    low, high = numpy.where(outside, t, low), numpy.where(outside, high, t)
nearest = AXES**2 * path / (AXES**2 + t[:, None])
normal = nearest / AXES**2
normal /= numpy.linalg.norm(normal, axis=1)[:, None]
depth = RADIUS - ((path - nearest) * normal).sum(axis=1)
truth = STIFFNESS * numpy.maximum(depth, 0)[:, None] * normal

# %%
error = 1e3 * numpy.linalg.norm(felt.wrench[:, :3] - truth, axis=1)
figure, (forces, errors) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), height_ratios=[2, 1])
for row, name in enumerate("xyz"):
    forces.plot(1e3 * path[:, 0], felt.wrench[:, row], color=f"C{row}", label=f"$F_{name}$")
    forces.plot(1e3 * path[::200, 0], truth[::200, row], "o", color=f"C{row}", fillstyle="none")
forces.set_ylabel("force in N")
forces.legend(title="line: felt; ring: true")
errors.plot(1e3 * path[:, 0], error)
errors.set_ylabel("error in mN")
errors.set_xlabel("hand along x in mm")
figure.tight_layout()
print(f"strongest {numpy.linalg.norm(truth, axis=1).max():.2f} N, error {error.mean():.1f} mN on average, {error.max():.1f} at most")

# %% [markdown]
# The remaining error is due to the facets: the mesh lies inside the ellipsoid by up to a hundredth of a millimetre.

# %%
assert error.mean() < 10
