"""Makes three_ports.csv, the motion of the ports of three_ports.yaml as one uncut system.

    python3 three_ports.py > three_ports.csv    20 s; needs numpy
    python3 three_ports.py --absolute           with beta K_R v, which damps rigid turning, too

One set of ordinary differential equations in minimal coordinates: the free nodes and three rigid
bodies, each of which carries the nodes of its port, x = p + R r. Virtual power over the velocities
u = (v of free nodes, v and w of bodies), with the nodal velocities T u and accelerations T u' + c:

    (T' M T + M_rigid) u' = T' (f - M c) + f_rigid + G' lambda,    G u' = gamma,

M the consistent mass of all nodes, the held ones too, lambda the force of the ball joint. Nodal
forces, with K_R = sum of R K_e R' (co-rotational elements; K_R is their stiffness at fixed R):

    f = weight - sum of R K_e (R' x - X) - alpha M v - beta K_R (v - v_ref).

Mass damping acts on absolute velocities, stiffness damping on those beyond the rigid motion of the
mean of the three ports: v_ref(x) = V + W x (x - P), with the means P of their origins, V of their
velocities, W of their angular velocities. Classical Runge-Kutta, h = 1e-5 s; the largest
difference from h = 2e-5 s goes to stderr. SI units, world axes.
"""

import sys
from pathlib import Path

import numpy as np

# three_ports.yaml, number by number.
GRAVITY = np.array([0.0, 0.0, -9.81])
YOUNG, POISSON, DENSITY = 2e5, 0.3, 1000.0
ALPHA, BETA = 2.0, 2e-4
DURATION, SAMPLE = 0.02, 0.004
BODY_MASS = [2.0, 3.0, 4.0]
BODY_INERTIA = np.array([[0.01, 0.01, 0.01], [0.02, 0.01, 0.01], [0.03, 0.01, 0.02]])
BODY_POSITION = np.array([[-0.05, 0.1, 0.05], [0.25, 0.1, 0.05], [0.1, 0.1, 0.2]])
PORT_SETS = ["x0", "x1", "zm"]  # port k sits on body k
PORT_POSITION = np.array([BODY_POSITION[0], [0.2, 0.1, 0.08], [0.1, 0.1, 0.15]])
PORT_ORIENTATION = np.array([[1.0, 0, 0, 0], [1.0, 0, 0, 0],
                             [0.8775825618903728, 0.479425538604203, 0, 0]])
BALL_BODY, BALL_ANCHOR = 0, [-0.1, 0.1, 0.05]
WORLD = None
SPRINGS = [  # body, point, body, point, k, c, rest length (None: as at t = 0)
    (1, [0.3, 0.12, 0.05], WORLD, [0.35, 0.2, 0.5], 2000.0, 40.0, None),
    (2, [0.1, 0.2, 0.2], 1, [0.28, 0.2, 0.07], 500.0, 5.0, 0.15),
]


def read_mesh(path):
    """Coordinates, tetrahedra and node sets; numbers from 0."""
    nodes, elements, sets, rows = [], [], {}, None
    for line in path.read_text().splitlines():
        if line.startswith("*"):
            words = [word.strip() for word in line.split(",")]
            rows = {"*NODE": nodes, "*ELEMENT": elements}.get(words[0])
            if words[0] == "*NSET":
                rows = sets.setdefault(words[1].split("=")[1], [])
        elif line.strip():
            rows.append([float(word) for word in line.split(",") if word.strip()])
    X = np.array([row[1:] for row in nodes])
    tets = np.array([row[1:] for row in elements], dtype=int) - 1
    return X, tets, {name: np.array(sum(r, []), dtype=int) - 1 for name, r in sets.items()}


def cross_matrix(a):
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def quaternion_product(a, b):
    return np.array([a[0] * b[0] - a[1:] @ b[1:],
                     *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def rotation(q):
    axis = cross_matrix(q[1:] / np.linalg.norm(q))
    return np.eye(3) + 2.0 * q[0] / np.linalg.norm(q) * axis + 2.0 * axis @ axis


class Continuum:
    """Linear tetrahedra, co-rotational, with consistent mass."""

    def __init__(self, X, tets):
        self.tets = tets
        corners = X[tets]
        # Affine interpolation: rows of `gradient` are the gradients of the four shape functions.
        affine = np.linalg.inv(np.concatenate([np.ones((len(tets), 4, 1)), corners], axis=2))
        self.gradient = np.swapaxes(affine[:, 1:, :], 1, 2)
        volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
        shear = YOUNG / (2.0 * (1.0 + POISSON))
        lame = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
        g = self.gradient
        # Second derivative of V (mu e:e + lame/2 tr(e)^2), e the symmetric displacement gradient.
        along = np.einsum("eai,ebj->eaibj", g, g)
        stiffness = (lame * along + shear * np.swapaxes(along, 2, 4)
                     + shear * np.einsum("eak,ebk,ij->eaibj", g, g, np.eye(3)))
        self.stiffness = volume[:, None, None, None, None] * stiffness
        self.reference = corners
        # Integral of N_a N_b: V/20, twice that for a = b.
        nodal = np.zeros((len(X), len(X)))
        for nodes, V in zip(tets, volume):
            nodal[np.ix_(nodes, nodes)] += DENSITY * V / 20.0 * (1.0 + np.eye(4))
        self.mass = np.kron(nodal, np.eye(3))
        self.weight = np.outer(nodal.sum(axis=1), GRAVITY)

    def forces(self, x, v_damped):
        """Elastic forces at x, and K_R times the velocities v_damped."""
        F = np.einsum("eai,eaj->eij", x[self.tets], self.gradient)
        left, _, right = np.linalg.svd(F)  # det F > 0, so the product is the polar rotation
        R = left @ right
        stretch = x[self.tets] @ R - self.reference  # rows R' x - X; K_e takes no translation
        elastic, viscous = np.zeros_like(x), np.zeros_like(x)
        for total, local in ((elastic, stretch), (viscous, v_damped[self.tets] @ R)):
            force = np.einsum("eaibj,ebj->eai", self.stiffness, local)
            np.add.at(total, self.tets, np.einsum("eij,eaj->eai", R, force))
        return elastic, viscous


class System:
    def __init__(self, absolute_damping):
        self.absolute_damping = absolute_damping
        self.X, tets, sets = read_mesh(Path(__file__).with_name("three_ports.inp"))
        self.continuum = Continuum(self.X, tets)
        self.held = [sets[name] for name in PORT_SETS]
        self.free = np.setdiff1d(np.arange(len(self.X)), np.concatenate(self.held))
        self.size = 3 * len(self.free) + 18
        # Bodies start with their axes along the world's, so arms are differences of positions.
        self.arms = [self.X[nodes] - BODY_POSITION[b] for b, nodes in enumerate(self.held)]
        self.rest = [np.linalg.norm(np.subtract(s[1], s[3])) if s[6] is None else s[6]
                     for s in SPRINGS]

    def at_rest(self):
        """State: x of free nodes, p of bodies, q of bodies, velocities u."""
        return np.concatenate([self.X[self.free].ravel(), BODY_POSITION.ravel(),
                               np.tile([1.0, 0, 0, 0], 3), np.zeros(self.size)])

    def unpack(self, y):
        n = 3 * len(self.free)
        u = y[n + 21:]
        twist = u[n:].reshape(3, 2, 3)
        return (y[:n].reshape(-1, 3), y[n:n + 9].reshape(3, 3), y[n + 9:n + 21].reshape(3, 4),
                u, twist[:, 0], twist[:, 1])

    def columns(self, body):
        """Where a body's (v, w) stand in u."""
        return slice(3 * len(self.free) + 6 * body, 3 * len(self.free) + 6 * body + 6)

    def point(self, body, place, p, R, w):
        """Point of a body that stood at `place`: position, Jacobian over u, acceleration at
        u' = 0. A point of the world: zero Jacobian."""
        jacobian = np.zeros((3, self.size))
        if body is WORLD:
            return np.array(place), jacobian, np.zeros(3)
        arm = R[body] @ (np.array(place) - BODY_POSITION[body])
        jacobian[:, self.columns(body)] = np.hstack([np.eye(3), -cross_matrix(arm)])
        return p[body] + arm, jacobian, np.cross(w[body], np.cross(w[body], arm))

    def reference_velocity(self, x, p, R, v, w):
        """Rigid velocity field at x of the mean of the ports."""
        arms = np.einsum("bij,bj->bi", R, PORT_POSITION - BODY_POSITION)
        origin = (p + arms).mean(axis=0)
        velocity = (v + np.cross(w, arms)).mean(axis=0)
        return velocity + np.cross(w.mean(axis=0), x - origin)

    def rate(self, y):
        x_free, p, q, u, v, w = self.unpack(y)
        R = np.array([rotation(each) for each in q])

        # Kinematics of all nodes.
        x, c = np.empty_like(self.X), np.zeros_like(self.X)
        T = np.zeros((len(self.X), 3, self.size))
        x[self.free] = x_free
        for k, node in enumerate(self.free):
            T[node, :, 3 * k:3 * k + 3] = np.eye(3)
        for b, nodes in enumerate(self.held):
            arms = self.arms[b] @ R[b].T
            x[nodes] = p[b] + arms
            c[nodes] = np.cross(w[b], np.cross(w[b], arms))
            for node, arm in zip(nodes, arms):
                T[node, :, self.columns(b)] = np.hstack([np.eye(3), -cross_matrix(arm)])
        T = T.reshape(-1, self.size)
        x_dot = (T @ u).reshape(-1, 3)

        damped = x_dot.copy()
        if not self.absolute_damping:
            damped -= self.reference_velocity(x, p, R, v, w)
        elastic, viscous = self.continuum.forces(x, damped)
        M = self.continuum.mass
        f = (self.continuum.weight - elastic - BETA * viscous).ravel() - ALPHA * M @ x_dot.ravel()
        A = T.T @ M @ T
        load = T.T @ (f - M @ c.ravel())

        for b in range(3):
            at = self.columns(b)
            J = R[b] @ np.diag(BODY_INERTIA[b]) @ R[b].T
            A[at, at][:3, :3] += BODY_MASS[b] * np.eye(3)
            A[at, at][3:, 3:] += J
            load[at] += np.concatenate([BODY_MASS[b] * GRAVITY, -np.cross(w[b], J @ w[b])])
        for (b1, place1, b2, place2, k, damping, _), rest in zip(SPRINGS, self.rest):
            x1, jacobian1, _ = self.point(b1, place1, p, R, w)
            x2, jacobian2, _ = self.point(b2, place2, p, R, w)
            length = np.linalg.norm(x2 - x1)
            length_over_u = (x2 - x1) / length @ (jacobian2 - jacobian1)
            load -= (k * (length - rest) + damping * length_over_u @ u) * length_over_u

        _, G, drift = self.point(BALL_BODY, BALL_ANCHOR, p, R, w)
        saddle = np.block([[A, G.T], [G, np.zeros((3, 3))]])
        u_dot = np.linalg.solve(saddle, np.concatenate([load, -drift]))[:self.size]

        q_dot = [0.5 * quaternion_product(np.array([0.0, *w[b]]), q[b]) for b in range(3)]
        return np.concatenate([u[:3 * len(self.free)], v.ravel(), np.ravel(q_dot), u_dot])

    def ports(self, y):
        """p, q, v, w of every port in a row."""
        _, p, q, _, v, w = self.unpack(y)
        row = []
        for b in range(3):
            arm = rotation(q[b]) @ (PORT_POSITION[b] - BODY_POSITION[b])
            attitude = quaternion_product(q[b] / np.linalg.norm(q[b]), PORT_ORIENTATION[b])
            row += [*(p[b] + arm), *attitude, *(v[b] + np.cross(w[b], arm)), *w[b]]
        return row


def trajectory(system, h):
    steps_per_sample = round(SAMPLE / h)
    y, rows = system.at_rest(), []
    for step in range(1, round(DURATION / h) + 1):
        k1 = system.rate(y)
        k2 = system.rate(y + 0.5 * h * k1)
        k3 = system.rate(y + 0.5 * h * k2)
        k4 = system.rate(y + h * k3)
        y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        if step % steps_per_sample == 0:
            rows.append(system.ports(y))
    return np.array(rows)


def main():
    system = System(absolute_damping="--absolute" in sys.argv[1:])
    rows = trajectory(system, 1e-5)
    change = np.abs(rows - trajectory(system, 2e-5)).max()
    print(f"largest difference from twice the step: {change:.2g}", file=sys.stderr)
    parts = ["p_x_m", "p_y_m", "p_z_m", "q_w", "q_x", "q_y", "q_z", "v_x_m_per_s", "v_y_m_per_s",
             "v_z_m_per_s", "w_x_rad_per_s", "w_y_rad_per_s", "w_z_rad_per_s"]
    print(",".join(["t_s"] + [f"p{port}.{part}" for port in (1, 2, 3) for part in parts]))
    for k, row in enumerate(rows):
        print(",".join(f"{value:.15g}" for value in [(k + 1) * SAMPLE, *row]))


if __name__ == "__main__":
    main()
