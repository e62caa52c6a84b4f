# %% [markdown]
# # The friction cone
#
# A ball is pressed onto a rough face and drawn across it, in 16 directions and with four normal forces, all in one call
# on all cores. By Coulomb's law it sticks until the drag is $\mu_s N$, in any direction, and slides at $\mu_d N$.

# %%
import matplotlib.pyplot as plt
import numpy
import palpate

MU_S, MU_D = 0.6, 0.4
block = palpate.body("block", *palpate.box([0.06, 0.04, 0.06]), static_friction=MU_S, dynamic_friction=MU_D)
model = palpate.Model([block], palpate.ball("ball", 0.005))

angles = numpy.linspace(0, 2 * numpy.pi, 16, endpoint=False)
presses = numpy.array([0.5e-3, 1e-3, 2e-3, 3e-3])
way = numpy.linspace(0, 5e-3, 800)
paths = numpy.zeros((len(presses), len(angles), len(way), 3))
paths[..., 0] = numpy.cos(angles)[:, None] * way
paths[..., 2] = numpy.sin(angles)[:, None] * way
paths[..., 1] = 0.025 - presses[:, None, None]
felt = model.follow(paths.reshape(-1, len(way), 3))
force = felt.wrench.reshape(*paths.shape[:3], 6)[..., :3]
felt

# %%
normal = force[:, :, -1, 1]
drag = numpy.hypot(force[..., 0], force[..., 2])
limit, sliding = drag.max(axis=2), drag[:, :, -100:].mean(axis=2)
figure, (cone, side) = plt.subplots(1, 2, figsize=(9.5, 4))
turn = numpy.linspace(0, 2 * numpy.pi, 200)
for i, press in enumerate(presses):
    at = drag[i].argmax(axis=1)
    greatest = force[i, numpy.arange(len(angles)), at]
    cone.plot(greatest[:, 0], greatest[:, 2], "o", color=f"C{i}", ms=4, label=f"{normal[i].mean():.1f} N")
    cone.plot(*(MU_S * normal[i].mean() * f(turn) for f in (numpy.cos, numpy.sin)), color=f"C{i}", lw=0.8)
cone.set_aspect("equal")
cone.set_xlabel("drag along x in N")
cone.set_ylabel("drag along z in N")
cone.legend(title="pressed by", loc="upper left", bbox_to_anchor=(1, 1))
line = numpy.array([0, normal.max()])
for mu, values, name, colour in ((MU_S, limit, "before it slips", "C0"), (MU_D, sliding, "while it slides", "C1")):
    side.plot(normal.ravel(), values.ravel(), "o", color=colour, ms=4, label=name)
    side.plot(line, mu * line, color=colour, lw=0.8, label=rf"$\mu = {mu}$")
side.set_xlabel("normal force in N")
side.set_ylabel("drag in N")
side.legend()
figure.tight_layout()
print(f"mu_s {(limit / normal).min():.4f} to {(limit / normal).max():.4f}, true {MU_S}")
print(f"mu_d {(sliding / normal).min():.4f} to {(sliding / normal).max():.4f}, true {MU_D}")

# %%
assert abs(limit / normal - MU_S).max() < 0.01 and abs(sliding / normal - MU_D).max() < 0.01
