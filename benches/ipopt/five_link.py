"""The walker of five links in CasADi with IPOPT: writes what the tests of `crates/trajectory` compare with.

    python3 benches/ipopt/five_link.py > crates/trajectory/tests/golden/five_link.csv

The problem is that of `crates/trajectory/tests/library/five_link.rs` (Kelly, SIAM Review 59, 2017), with the same
transcription, variables, scales, limits and start. The equations of motion come from the Lagrangian by automatic
differentiation; their sums over the links beyond a joint are the angular momenta that the other file writes down.
Multipliers are in the units of the problem, positive where an upper limit holds.
"""

import casadi as ca
import numpy as np
from compare import INF, SCHEMES, Nlp, transcribe

MASS, INERTIA = [3.2, 6.8, 20.0, 6.8, 3.2], [0.93, 1.08, 2.22, 1.08, 0.93]
LEG, SHIN, THIGH, G = 0.4, 0.128, 0.163, 9.81
LINKS, MOTORS = 5, 4
NAMES = ["stance shin", "stance thigh", "torso", "swing thigh", "swing shin"]
TORQUES = ["stance knee", "stance hip", "swing hip", "swing knee"]
PAPER = dict(step=0.5, duration=0.7, torso=0.2, clearance=0.0, torque=100.0, knees=True)
CASES = {
    "published": PAPER,
    "logged": PAPER | dict(step=0.4, duration=0.6, torso=0.425, knees=False),
    "held": PAPER | dict(clearance=0.1, torque=30.0),
}
SCALE = {"q": 1.0, "v": 5.0, "a": 50.0, "u": 30.0, "row": 30.0, "momentum": 10.0}
INACTIVE = 1e-6  # what the interior-point method leaves of the multiplier of a limit that does not hold
COARSE = {"Hermite-Simpson": 12, "Radau IIA 3": 8}


def unit(q):
    return ca.vertcat(-ca.sin(q), ca.cos(q))


def centres(q, torso):
    """Centres of mass of the links, stance foot in the origin."""
    e = [unit(angle) for angle in ca.vertsplit(q)]
    knee = LEG * e[0]
    hip = knee + LEG * e[1]
    swing_knee = hip - LEG * e[3]
    return [knee - SHIN * e[0], hip - THIGH * e[1], hip + torso * e[2], hip - THIGH * e[3], swing_knee - SHIN * e[4]]


def points(q):
    """Stance foot, stance knee, hip, swing knee, swing foot."""
    e = [unit(angle) for angle in ca.vertsplit(q)]
    hip = LEG * (e[0] + e[1])
    return [ca.SX.zeros(2), LEG * e[0], hip, hip - LEG * e[3], hip - LEG * (e[3] + e[4])]


def moments(torso):
    """d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q, summed over the links beyond each joint, as a function of q, q̇, q̈."""
    q, v, a = (ca.SX.sym(name, LINKS) for name in "qva")
    kinetic = potential = 0
    for k, centre in enumerate(centres(q, torso)):
        speed = ca.jtimes(centre, q, v)
        kinetic += 0.5 * MASS[k] * ca.dot(speed, speed) + 0.5 * INERTIA[k] * v[k] ** 2
        potential += MASS[k] * G * centre[1]
    momentum = ca.gradient(kinetic, v)
    force = ca.jtimes(momentum, q, v) + ca.jtimes(momentum, v, a) - ca.gradient(kinetic, q) + ca.gradient(potential, q)
    beyond = ca.vertcat(*(ca.sum1(force[joint:]) for joint in range(LINKS)))
    return ca.Function("moments", [q, v, a], [beyond])


def angular_momentum(q, v, links, about, torso):
    total = 0
    for k in links:
        centre = centres(q, torso)[k]
        arm, speed = centre - about, ca.jtimes(centre, q, v)
        total += MASS[k] * (arm[0] * speed[1] - arm[1] * speed[0]) + INERTIA[k] * v[k]
    return total


def strike(torso):
    """Angular momenta after minus before, about the new stance foot, its knee, the hip (twice) and the other knee."""
    q, v, r, w = (ca.SX.sym(name, LINKS) for name in "qvrw")
    old, new = points(q), points(r)
    rows = []
    for joint, root in enumerate([0, 1, 2, 2, 3]):
        before = angular_momentum(q, v, range(LINKS - joint), old[4 - root], torso)
        rows.append(angular_momentum(r, w, range(joint, LINKS), new[root], torso) - before)
    return ca.Function("strike", [q, v, r, w], [ca.vertcat(*rows)])


def build(case, nodes, intervals):
    nlp = Nlp()
    momenta, jump = moments(case["torso"]), strike(case["torso"])
    stance = np.array([-0.3, 0.7, 0.0, -0.5, -0.6])
    away = stance[::-1] - stance
    guess = lambda share: {
        "q": list(stance + away * share), "v": list(away / case["duration"]), "a": [0.0] * LINKS, "u": [0.0] * MOTORS,
        "s": [], "rate": [],
    }
    axis = {"q": (-np.pi / 2, np.pi / 2, SCALE["q"]), "v": (-10.0, 10.0, SCALE["v"]), "a": (-INF, INF, SCALE["a"])}

    def point(p):
        q, v, a, u = (ca.vertcat(*p[name]) for name in "qvau")
        foot = points(q)[4]
        nlp.limited.append(((foot[1] - case["clearance"] * (1 - (foot[0] / case["step"]) ** 2)) / 0.1, -0.01, INF))
        if case["knees"]:
            nlp.limited += [(q[1] - q[0], 0.0, INF), (q[3] - q[4], 0.0, INF)]
        return ca.dot(u, u), ca.vertsplit((momenta(q, v, a) - ca.vertcat(0, u)) / SCALE["row"])

    limits = (-case["torque"], case["torque"], SCALE["u"])
    p = transcribe(nlp, nodes, intervals, case["duration"], [axis] * LINKS, [], [limits] * MOTORS, guess, point)
    q, v, r, w = (ca.vertcat(*p[end][name]) for end in (-1, 0) for name in "qv")
    foot = points(q)[4]
    rise = lambda q, v: ca.jtimes(points(q)[4][1], q, v)
    q_, v_ = ca.SX.sym("q", LINKS), ca.SX.sym("v", LINKS)
    rising = ca.Function("rising", [q_, v_], [rise(q_, v_)])
    nlp.rows += ca.vertsplit(r - q[::-1]) + ca.vertsplit(jump(q, v, r, w) / SCALE["momentum"]) + [foot[0] - case["step"], foot[1]]
    nlp.limited += [(rising(r, w), 0.0, INF), (rising(q, v), -INF, 0.0)]
    return nlp


def multipliers(answer, nlp, case, nodes, intervals):
    """Block by block, as the library names them: defects, points, strike; and the bounds that hold."""
    y, rows = answer["row_multipliers"], len(nlp.rows)
    fresh = [c for c in nodes if c > 0.0]
    count = intervals * len(fresh) + (nodes[0] == 0.0)
    defects = y[: intervals * len(fresh) * LINKS * 2].reshape(intervals, len(fresh), LINKS, 2)
    for k in range(intervals):
        for j, name in enumerate(NAMES):
            yield f"step, interval {k}, {name}", (defects[k, :, j] / [SCALE["q"], SCALE["v"]]).ravel()
    equal = y[defects.size : defects.size + count * LINKS].reshape(count, LINKS) / SCALE["row"]
    held = y[rows:-2].reshape(count, -1) / ([0.1, 1.0, 1.0] if case["knees"] else [0.1])
    first = 0 if nodes[0] == 0.0 else 1
    for n in range(count):
        yield f"step, point {first + n}", np.concatenate([equal[n], held[n]])
    ends = y[rows - 12 : rows] / ([SCALE["q"]] * LINKS + [SCALE["momentum"]] * LINKS + [1.0, 1.0])
    yield "strike and change of legs", np.concatenate([ends, y[-2:]])


def bounds(answer, nlp, nodes):
    """Multipliers of the bounds of the torques, point by point; no other bound holds in any case."""
    z, at, first = answer["bound_multipliers"] / np.array(nlp.scale), 0, nodes[0] == 0.0
    n = 0
    while at < len(z):
        size = 2 * LINKS + (LINKS + MOTORS) * (n > 0 or first)
        if size > 2 * LINKS:
            yield f"bounds, point {n}", z[at + size - MOTORS : at + size]
        at, n = at + size, n + 1


def main():
    sharp = dict(repeats=1, tol=1e-12, bound_relax_factor=0.0, obj_scaling_factor=1 / 300)
    print(f"# The walker of five links by IPOPT (MUMPS) through CasADi {ca.__version__}, from benches/ipopt/five_link.py")
    print("# cost, case, scheme, intervals, cost in N² m² s; then multipliers, case, scheme, block, one a row")
    for name, case in CASES.items():
        for scheme, nodes in SCHEMES.items():
            answer = build(case, nodes, 25).solve(**sharp)
            assert answer["status"] == "Solve_Succeeded", answer["status"]
            print(f"cost;{name};{scheme};25;{answer['cost']:.13e}")
    for name in ("published", "held"):
        for scheme, intervals in COARSE.items():
            nlp = build(CASES[name], SCHEMES[scheme], intervals)
            answer = nlp.solve(**sharp)
            assert answer["status"] == "Solve_Succeeded", answer["status"]
            print(f"cost;{name};{scheme};{intervals};{answer['cost']:.13e}")
            lists = [*multipliers(answer, nlp, CASES[name], SCHEMES[scheme], intervals), *bounds(answer, nlp, SCHEMES[scheme])]
            for block, values in lists:
                print(f"multipliers;{name};{scheme};{block};" + " ".join(f"{0.0 if abs(v) < INACTIVE else v:.9g}" for v in values))


if __name__ == "__main__":
    main()
