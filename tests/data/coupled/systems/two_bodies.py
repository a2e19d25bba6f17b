"""Makes two_bodies.csv, the motion of the ports of two_bodies.yaml as one uncut system.

    python3 two_bodies.py > two_bodies.csv    40 s; needs numpy
    python3 two_bodies.py --damped > two_bodies_damped.csv    with beta_s = 4e-3 on the strut

The equations: uncut_system.py. A loop of two flexible bodies, which meet at one rigid body that
carries a port of each (the hub) and at a hinge between two that carry a port each (foot and heel).
"""

import sys

from uncut_system import WORLD, Flexible, Hinge, Port, Rigid, Spring, System, print_trajectory

# two_bodies.yaml, number by number.
SPAR, STRUT = 0, 1
FLEXIBLE = [Flexible("both_ends.inp", young=1e5, poisson=0.3, density=1000.0, alpha=2.0, beta=2e-4),
            Flexible("two_bodies.inp", young=3e5, poisson=0.2, density=600.0, alpha=1.0,
                     beta=4e-3 if "--damped" in sys.argv else 2e-5)]
FOOT, HEEL, HUB = 0, 1, 2
RIGID = [Rigid(2.0, [0.01, 0.02, 0.01], [-0.06, 0.05, 0.05]),
         Rigid(3.0, [0.02, 0.01, 0.02], [-0.15, 0.25, 0.05]),
         Rigid(4.0, [0.04, 0.02, 0.03], [0.27, 0.15, 0.06])]
PORTS = [Port(SPAR, "x0", FOOT, [0.0, 0.05, 0.05]),
         Port(STRUT, "x1", HUB, [0.2, 0.25, 0.05],
              [0.8775825618903728, 0.479425538604203, 0.0, 0.0]),
         Port(SPAR, "x1", HUB, [0.2, 0.05, 0.06]),
         Port(STRUT, "x0", HEEL, [-0.15, 0.25, 0.05])]
SPRINGS = [Spring(HUB, [0.3, 0.1, 0.05], WORLD, [0.35, 0.2, 0.5], 2000.0, 40.0, rest=0.44),
           Spring(HEEL, [-0.2, 0.25, 0.1], WORLD, [-0.3, 0.4, 0.4], 800.0, 10.0, rest=0.2),
           Spring(FOOT, [-0.06, -0.02, 0.1], HUB, [0.2, 0.05, 0.2], 1000.0, 5.0, rest=0.2)]
JOINTS = [Hinge(FOOT, HEEL, [-0.1, 0.15, 0.05], [0.0, 1.0, 0.5])]

if __name__ == "__main__":
    system = System([0.0, 0.0, -9.81], FLEXIBLE, RIGID, PORTS, SPRINGS, JOINTS)
    print_trajectory(system, ["spar_foot", "strut_hub", "spar_hub", "strut_heel"], duration=0.02,
                     sample=0.004)
