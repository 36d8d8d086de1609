"""An oracle that shares no code with the package: dense 4x4 exponentials at 50 digits, from the description of a robot."""

import mpmath as mp


def matrix(rows):
    return mp.matrix([[mp.mpf(float(x)) for x in row] for row in rows])


def twist_matrix(screw):
    v, w = [mp.mpf(float(x)) for x in screw[:3]], [mp.mpf(float(x)) for x in screw[3:]]
    return mp.matrix([[0, -w[2], w[1], v[0]], [w[2], 0, -w[0], v[1]], [-w[1], w[0], 0, v[2]], [0, 0, 0, 0]])


def pose_derivative(description, q, link, name):
    """d pose / d q[name] at 50 digits, by a difference quotient whose step is far below double precision."""
    mp.mp.dps = 50
    step = mp.mpf(10) ** -20

    def moved(sign):
        shifted = {k: mp.mpf(float(v)) + (sign * step if k == name else 0) for k, v in q.items()}
        return exact_poses(description, shifted)[link]

    return (moved(1) - moved(-1)) / (2 * step)


def exact_poses(description, q):
    by_name = {joint.name: joint for joint in description.joints}

    def value(joint):
        if joint.mimic is None:
            return q[joint.name]
        return mp.mpf(joint.mimic.multiplier) * value(by_name[joint.mimic.joint]) + mp.mpf(joint.mimic.offset)

    poses = {description.links[0].name: mp.eye(4)}
    for joint in description.joints:
        hop = matrix(joint.placement)
        if joint.kind != "fixed":
            hop = hop * mp.expm(twist_matrix(joint.screw) * value(joint), method="taylor")
        poses[joint.child] = poses[joint.parent] * hop
    return poses


def jacobian(description, q, link, names):
    """6 x n, linear rows first, base axes, at the link's origin: v = dp/dq, [w] = dR/dq R^T."""
    T = exact_poses(description, {k: mp.mpf(float(v)) for k, v in q.items()})[link]
    columns = []
    for name in names:
        D = pose_derivative(description, q, link, name)
        W = D[:3, :3] * T[:3, :3].T
        columns.append([D[0, 3], D[1, 3], D[2, 3], W[2, 1], W[0, 2], W[1, 0]])
    return [[float(column[r]) for column in columns] for r in range(6)]
