"""Flexible and rigid bodies as one uncut system: what the programs beside this file integrate.

One set of ordinary differential equations in minimal coordinates: the free nodes of all flexible
bodies, and the rigid bodies, which carry the nodes of their ports, x = p + R r. Virtual power over
the velocities u = (v of free nodes, v and w of rigid bodies), with the velocities T u and the
accelerations T u' + c of a flexible body's nodes:

    (sum of T' M T + M_rigid) u' = sum of T' (f - M c) + f_rigid + G' lambda,    G u' = gamma,

M the consistent mass of all nodes of a body, the held ones too, lambda the forces of the joints.
Nodal forces, with K_R = sum of R K_e R' (co-rotational elements; K_R is their stiffness at fixed R):

    f = weight - sum of R K_e (R' x - X) - alpha M v - beta K_R (v - v_ref).

Mass damping acts on absolute velocities, stiffness damping on those beyond the rigid motion of the
mean of the body's ports: v_ref(x) = V + W x (x - P), with the means P of their origins, V of their
velocities, W of their angular velocities. Classical Runge-Kutta. SI units, world axes.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

WORLD = None


@dataclass
class Rigid:
    mass: float
    inertia: list  # principal, its axes along the world's at t = 0
    position: list


@dataclass
class Flexible:
    mesh: str  # file beside this one
    young: float
    poisson: float
    density: float
    alpha: float
    beta: float


@dataclass
class Port:
    flexible: int
    node_set: str
    rigid: int
    position: list
    orientation: list = field(default_factory=lambda: [1.0, 0.0, 0.0, 0.0])


@dataclass
class Spring:
    body1: int
    point1: list
    body2: int  # or WORLD
    point2: list
    stiffness: float
    damping: float
    rest: float = None  # None: as at t = 0


@dataclass
class Ball:
    """A point of the body stays where it is."""
    body: int
    anchor: list

    def equations(self, system, p, R, w):
        """G and -gamma."""
        _, G, drift = system.point(self.body, self.anchor, p, R, w)
        return G, drift


@dataclass
class Hinge:
    """Two bodies share a point and an axis a: a1 . b2 = a1 . c2 = 0, b and c normal to it."""
    body1: int
    body2: int
    anchor: list
    axis: list

    def equations(self, system, p, R, w):
        one, two = self.body1, self.body2
        _, G1, drift1 = system.point(one, self.anchor, p, R, w)
        _, G2, drift2 = system.point(two, self.anchor, p, R, w)
        G, drift = [G1 - G2], [drift1 - drift2]
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        across = np.linalg.svd(axis[None, :])[2][1:]
        a = R[one] @ axis
        for b in across @ R[two].T:
            # d/dt (a . b) = n . (w1 - w2) with n = a x b.
            n = np.cross(a, b)
            n_dot = np.cross(np.cross(w[one], a), b) + np.cross(a, np.cross(w[two], b))
            row = np.zeros((1, system.size))
            row[0, system.columns(one)] += [0.0, 0.0, 0.0, *n]
            row[0, system.columns(two)] -= [0.0, 0.0, 0.0, *n]
            G.append(row)
            drift.append([n_dot @ (w[one] - w[two])])
        return np.vstack(G), np.concatenate(drift)


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

    def __init__(self, X, tets, body, gravity):
        self.tets = tets
        corners = X[tets]
        # Affine interpolation: rows of `gradient` are the gradients of the four shape functions.
        affine = np.linalg.inv(np.concatenate([np.ones((len(tets), 4, 1)), corners], axis=2))
        self.gradient = np.swapaxes(affine[:, 1:, :], 1, 2)
        volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
        shear = body.young / (2.0 * (1.0 + body.poisson))
        lame = body.young * body.poisson / ((1.0 + body.poisson) * (1.0 - 2.0 * body.poisson))
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
            nodal[np.ix_(nodes, nodes)] += body.density * V / 20.0 * (1.0 + np.eye(4))
        self.mass = np.kron(nodal, np.eye(3))
        self.weight = np.outer(nodal.sum(axis=1), gravity)

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


class Nodes:
    """A flexible body: its mesh, its ports, and where its free nodes stand in u."""

    def __init__(self, body, ports, rigid, gravity, begin):
        self.body, self.ports = body, ports
        self.X, tets, sets = read_mesh(Path(__file__).with_name(body.mesh))
        self.continuum = Continuum(self.X, tets, body, gravity)
        self.held = [sets[port.node_set] for port in ports]
        self.free = np.setdiff1d(np.arange(len(self.X)), np.concatenate(self.held))
        self.begin, self.end = begin, begin + 3 * len(self.free)
        # Rigid bodies start with their axes along the world's: arms are differences of positions.
        self.arms = [self.X[nodes] - rigid[port.rigid].position
                     for port, nodes in zip(ports, self.held)]
        self.origins = np.array([np.subtract(port.position, rigid[port.rigid].position)
                                 for port in ports])

    def reference_velocity(self, x, p, R, v, w):
        """Rigid velocity field at x of the mean of the ports."""
        on = [port.rigid for port in self.ports]
        arms = np.einsum("bij,bj->bi", R[on], self.origins)
        origin = (p[on] + arms).mean(axis=0)
        velocity = (v[on] + np.cross(w[on], arms)).mean(axis=0)
        return velocity + np.cross(w[on].mean(axis=0), x - origin)


class System:
    def __init__(self, gravity, flexible, rigid, ports, springs=(), joints=(),
                 absolute_damping=False):
        self.gravity, self.rigid, self.ports = np.array(gravity), rigid, ports
        self.springs, self.joints = springs, joints
        self.absolute_damping = absolute_damping
        self.flexible, at = [], 0
        for k, body in enumerate(flexible):
            own = [port for port in ports if port.flexible == k]
            self.flexible.append(Nodes(body, own, rigid, self.gravity, at))
            at = self.flexible[-1].end
        self.free = at
        self.size = at + 6 * len(rigid)
        self.rest = [np.linalg.norm(np.subtract(s.point1, s.point2)) if s.rest is None else s.rest
                     for s in springs]

    def at_rest(self):
        """State: x of free nodes, p and q of rigid bodies, velocities u."""
        return np.concatenate([*(each.X[each.free].ravel() for each in self.flexible),
                               np.ravel([body.position for body in self.rigid]),
                               np.tile([1.0, 0, 0, 0], len(self.rigid)), np.zeros(self.size)])

    def unpack(self, y):
        n, bodies = self.free, len(self.rigid)
        u = y[n + 7 * bodies:]
        twist = u[n:].reshape(bodies, 2, 3)
        return (y[:n], y[n:n + 3 * bodies].reshape(-1, 3),
                y[n + 3 * bodies:n + 7 * bodies].reshape(-1, 4), u, twist[:, 0], twist[:, 1])

    def columns(self, body):
        """Where a rigid body's (v, w) stand in u."""
        return slice(self.free + 6 * body, self.free + 6 * body + 6)

    def point(self, body, place, p, R, w):
        """Point of a body that stood at `place`: position, Jacobian over u, acceleration at
        u' = 0. A point of the world: zero Jacobian."""
        jacobian = np.zeros((3, self.size))
        if body is WORLD:
            return np.array(place), jacobian, np.zeros(3)
        arm = R[body] @ (np.array(place) - self.rigid[body].position)
        jacobian[:, self.columns(body)] = np.hstack([np.eye(3), -cross_matrix(arm)])
        return p[body] + arm, jacobian, np.cross(w[body], np.cross(w[body], arm))

    def add_flexible(self, nodes, state, A, load):
        """T' M T and T' (f - M c) of a flexible body."""
        x_free, p, R, u, v, w = state
        x, c = np.empty_like(nodes.X), np.zeros_like(nodes.X)
        T = np.zeros((len(nodes.X), 3, self.size))
        x[nodes.free] = x_free[nodes.begin:nodes.end].reshape(-1, 3)
        for k, node in enumerate(nodes.free):
            T[node, :, nodes.begin + 3 * k:nodes.begin + 3 * k + 3] = np.eye(3)
        for port, held, arms_B in zip(nodes.ports, nodes.held, nodes.arms):
            b = port.rigid
            arms = arms_B @ R[b].T
            x[held] = p[b] + arms
            c[held] = np.cross(w[b], np.cross(w[b], arms))
            for node, arm in zip(held, arms):
                T[node, :, self.columns(b)] = np.hstack([np.eye(3), -cross_matrix(arm)])
        T = T.reshape(-1, self.size)
        x_dot = (T @ u).reshape(-1, 3)

        damped = x_dot.copy()
        if not self.absolute_damping:
            damped -= nodes.reference_velocity(x, p, R, v, w)
        elastic, viscous = nodes.continuum.forces(x, damped)
        M = nodes.continuum.mass
        f = ((nodes.continuum.weight - elastic - nodes.body.beta * viscous).ravel()
             - nodes.body.alpha * M @ x_dot.ravel())
        A += T.T @ M @ T
        load += T.T @ (f - M @ c.ravel())

    def add_rigid(self, R, w, A, load):
        for b, body in enumerate(self.rigid):
            at = self.columns(b)
            J = R[b] @ np.diag(body.inertia) @ R[b].T
            A[at, at][:3, :3] += body.mass * np.eye(3)
            A[at, at][3:, 3:] += J
            load[at] += np.concatenate([body.mass * self.gravity, -np.cross(w[b], J @ w[b])])

    def add_springs(self, p, R, u, w, load):
        for spring, rest in zip(self.springs, self.rest):
            x1, jacobian1, _ = self.point(spring.body1, spring.point1, p, R, w)
            x2, jacobian2, _ = self.point(spring.body2, spring.point2, p, R, w)
            length = np.linalg.norm(x2 - x1)
            length_over_u = (x2 - x1) / length @ (jacobian2 - jacobian1)
            load -= ((spring.stiffness * (length - rest) + spring.damping * length_over_u @ u)
                     * length_over_u)

    def rate(self, y):
        x_free, p, q, u, v, w = self.unpack(y)
        R = np.array([rotation(each) for each in q])
        A, load = np.zeros((self.size, self.size)), np.zeros(self.size)
        for nodes in self.flexible:
            self.add_flexible(nodes, (x_free, p, R, u, v, w), A, load)
        self.add_rigid(R, w, A, load)
        self.add_springs(p, R, u, w, load)

        equations = [joint.equations(self, p, R, w) for joint in self.joints]
        G = np.vstack([each[0] for each in equations])
        drift = np.concatenate([each[1] for each in equations])
        saddle = np.block([[A, G.T], [G, np.zeros((len(G), len(G)))]])
        u_dot = np.linalg.solve(saddle, np.concatenate([load, -drift]))[:self.size]

        q_dot = [0.5 * quaternion_product(np.array([0.0, *each[0]]), each[1]) for each in zip(w, q)]
        return np.concatenate([u[:self.free], v.ravel(), np.ravel(q_dot), u_dot])

    def motions(self, y):
        """p, q, v, w of every port in a row."""
        _, p, q, _, v, w = self.unpack(y)
        row = []
        for port in self.ports:
            b = port.rigid
            arm = rotation(q[b]) @ np.subtract(port.position, self.rigid[b].position)
            attitude = quaternion_product(q[b] / np.linalg.norm(q[b]), np.array(port.orientation))
            row += [*(p[b] + arm), *attitude, *(v[b] + np.cross(w[b], arm)), *w[b]]
        return row


def trajectory(system, duration, sample, h):
    """Motions of the ports every `sample` seconds."""
    steps_per_sample = round(sample / h)
    y, rows = system.at_rest(), []
    for step in range(1, round(duration / h) + 1):
        k1 = system.rate(y)
        k2 = system.rate(y + 0.5 * h * k1)
        k3 = system.rate(y + 0.5 * h * k2)
        k4 = system.rate(y + h * k3)
        y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        if step % steps_per_sample == 0:
            rows.append(system.motions(y))
    return np.array(rows)


def print_trajectory(system, names, duration, sample):
    """With h = 1e-5 s; the largest difference from h = 2e-5 s goes to stderr."""
    rows = trajectory(system, duration, sample, 1e-5)
    change = np.abs(rows - trajectory(system, duration, sample, 2e-5)).max()
    print(f"largest difference from twice the step: {change:.2g}", file=sys.stderr)
    parts = ["p_x_m", "p_y_m", "p_z_m", "q_w", "q_x", "q_y", "q_z", "v_x_m_per_s", "v_y_m_per_s",
             "v_z_m_per_s", "w_x_rad_per_s", "w_y_rad_per_s", "w_z_rad_per_s"]
    print(",".join(["t_s"] + [f"{name}.{part}" for name in names for part in parts]))
    for k, row in enumerate(rows):
        print(",".join(f"{value:.15g}" for value in [(k + 1) * sample, *row]))
