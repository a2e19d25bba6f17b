"""Makes three_ports.csv, the motion of the ports of three_ports.yaml as one uncut system.

    python3 three_ports.py > three_ports.csv    20 s; needs numpy
    python3 three_ports.py --absolute           with beta K_R v, which damps rigid turning, too

The equations: uncut_system.py. One flexible body between three rigid ones, one of them on a ball
joint.
"""

import sys

from uncut_system import WORLD, Ball, Flexible, Port, Rigid, Spring, System, print_trajectory

# three_ports.yaml, number by number.
FLEXIBLE = [Flexible("three_ports.inp", young=2e5, poisson=0.3, density=1000.0, alpha=2.0,
                     beta=2e-4)]
RIGID = [Rigid(2.0, [0.01, 0.01, 0.01], [-0.05, 0.1, 0.05]),
         Rigid(3.0, [0.02, 0.01, 0.01], [0.25, 0.1, 0.05]),
         Rigid(4.0, [0.03, 0.01, 0.02], [0.1, 0.1, 0.2])]
PORTS = [Port(0, "x0", 0, [-0.05, 0.1, 0.05]),
         Port(0, "x1", 1, [0.2, 0.1, 0.08]),
         Port(0, "zm", 2, [0.1, 0.1, 0.15], [0.8775825618903728, 0.479425538604203, 0.0, 0.0])]
SPRINGS = [Spring(1, [0.3, 0.12, 0.05], WORLD, [0.35, 0.2, 0.5], 2000.0, 40.0),
           Spring(2, [0.1, 0.2, 0.2], 1, [0.28, 0.2, 0.07], 500.0, 5.0, rest=0.15)]
JOINTS = [Ball(0, [-0.1, 0.1, 0.05])]

if __name__ == "__main__":
    system = System([0.0, 0.0, -9.81], FLEXIBLE, RIGID, PORTS, SPRINGS, JOINTS,
                    absolute_damping="--absolute" in sys.argv[1:])
    print_trajectory(system, ["p1", "p2", "p3"], duration=0.02, sample=0.004)
