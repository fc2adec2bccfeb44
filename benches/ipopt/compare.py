"""The control problems of the test library in CasADi with IPOPT, beside ours.

Same transcription, variables, scales, bounds and starts; CasADi's exact
derivatives and IPOPT's defaults (MUMPS) with tol 1e-9. Times are IPOPT's own
total and our best of five; the ratio is what counts. See README.md.
"""

import json
import subprocess
import sys

import casadi as ca
import numpy as np

SCHEMES = {
    "trapezoid": [0.0, 1.0],
    "Hermite-Simpson": [0.0, 0.5, 1.0],
    "Radau IIA 2": [1 / 3, 1.0],
    "Radau IIA 3": [(4 - 6**0.5) / 10, (4 + 6**0.5) / 10, 1.0],
}


def tables(nodes):
    """First and second integrals of the Lagrange polynomials, and the weights."""
    k = len(nodes)
    first, second, weights = np.zeros((k, k)), np.zeros((k, k)), np.zeros(k)
    for j in range(k):
        p = np.poly1d([1.0])
        for m in range(k):
            if m != j:
                p *= np.poly1d([1.0, -nodes[m]]) / (nodes[j] - nodes[m])
        once = p.integ()
        twice = once.integ()
        weights[j] = once(1.0) - once(0.0)
        for i, c in enumerate(nodes):
            first[i, j] = once(c) - once(0.0)
            second[i, j] = twice(c) - twice(0.0)
    return first, second, weights


class Nlp:
    """Variables with scales, rows (zero, or `limited` to a range) and a cost, collected one by one."""

    def __init__(self):
        self.x, self.low, self.high, self.start, self.scale = [], [], [], [], []
        self.rows, self.limited, self.cost = [], [], 0

    def variable(self, start, low=-np.inf, high=np.inf, scale=1.0):
        symbol = ca.SX.sym(f"x{len(self.x)}")
        self.x.append(symbol)
        self.low.append(low / scale)
        self.high.append(high / scale)
        self.start.append(start / scale)
        self.scale.append(scale)
        return symbol * scale

    def solve(self, repeats=5, **ipopt):
        problem = {"x": ca.vertcat(*self.x), "f": self.cost, "g": ca.vertcat(*self.rows, *(row for row, _, _ in self.limited))}
        options = {"print_time": False, "record_time": True, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-9} | ipopt}
        solver = ca.nlpsol("s", "ipopt", problem, options)
        low, high = ([0.0] * len(self.rows) + [limits[k] for limits in self.limited] for k in (1, 2))
        best = np.inf
        for _ in range(repeats):
            answer = solver(x0=self.start, lbx=self.low, ubx=self.high, lbg=low, ubg=high)
            stats = solver.stats()
            best = min(best, stats["t_wall_total"])  # IPOPT with the functions it calls
        return {
            "status": stats["return_status"],
            "cost": float(answer["f"]),
            "iterations": stats["iter_count"],
            "seconds": best,
            "variables": len(self.x),
            "row_multipliers": np.array(answer["lam_g"]).ravel(),
            "bound_multipliers": np.array(answer["lam_x"]).ravel(),
        }


def transcribe(nlp, nodes, intervals, duration, coordinates, states, controls, guess, point):
    """Second-order collocation; `point(q, v, a, s, rate, u)` gives running cost and rows."""
    first, second, weights = tables(nodes)
    shared = nodes[0] == 0.0
    h = duration / intervals

    def make(share, dynamic):
        g = guess(share)
        p = {
            "q": [nlp.variable(g["q"][k], *c["q"]) for k, c in enumerate(coordinates)],
            "v": [nlp.variable(g["v"][k], *c["v"]) for k, c in enumerate(coordinates)],
            "s": [nlp.variable(g["s"][k], *c["s"]) for k, c in enumerate(states)],
        }
        if dynamic:
            p["a"] = [nlp.variable(g["a"][k], *c["a"]) for k, c in enumerate(coordinates)]
            p["rate"] = [nlp.variable(g["rate"][k], *c["rate"]) for k, c in enumerate(states)]
            p["u"] = [nlp.variable(g["u"][k], *c) for k, c in enumerate(controls)]
        return p

    start = make(0.0, shared)
    points, weight = [start], [0.0]
    for i in range(intervals):
        fresh = [make((i + c) / intervals, True) for c in nodes if c > 0.0]
        span = ([points[-1]] if shared else []) + fresh
        base = points[-1]
        if shared:
            weight[-1] += weights[0]
        weight += list(weights[1:] if shared else weights)
        for n, c in enumerate(nodes):
            if c == 0.0:
                continue
            for k, spec in enumerate(coordinates):
                a = [p["a"][k] for p in span]
                v = base["v"][k] + h * sum(first[n, j] * a[j] for j in range(len(a)))
                q = base["q"][k] + h * c * base["v"][k] + h * h * sum(second[n, j] * a[j] for j in range(len(a)))
                nlp.rows += [(span[n]["q"][k] - q) / spec["q"][2], (span[n]["v"][k] - v) / spec["v"][2]]
            for k, spec in enumerate(states):
                r = [p["rate"][k] for p in span]
                s = base["s"][k] + h * sum(first[n, j] * r[j] for j in range(len(r)))
                nlp.rows.append((span[n]["s"][k] - s) / spec["s"][2])
        points += fresh
    for p, w in zip(points, weight):
        if "a" in p:
            cost, rows = point(p)
            nlp.cost += w * h * cost
            nlp.rows += rows
    return points


INF = np.inf


def double_integrator(nodes):
    nlp = Nlp()
    duration = nlp.variable(3.0, 0.1, 100.0)
    axis = {"q": (-INF, INF, 1.0), "v": (-INF, INF, 1.0), "a": (-1.0, 1.0, 1.0)}
    guess = lambda share: {"q": [share], "v": [1 / 3], "a": [0.0], "s": [], "rate": [], "u": []}
    p = transcribe(nlp, nodes, 10, duration, [axis], [], [], guess, lambda p: (0, []))
    nlp.rows += [p[0]["q"][0], p[0]["v"][0], p[-1]["q"][0] - 1.0, p[-1]["v"][0]]
    nlp.cost += duration
    return nlp


def brachistochrone(nodes):
    x, y, g = 10.0, 5.0, 9.81
    nlp = Nlp()
    duration = nlp.variable(2.0, 0.1, 100.0)
    states = [{"s": (-INF, INF, k), "rate": (-INF, INF, k)} for k in (x, y, 10.0)]
    guess = lambda share: {
        "q": [], "v": [], "a": [], "s": [x * share, y * share, 8 * share],
        "rate": [x / 2, y / 2, 4.0], "u": [0.2 + 1.3 * share],
    }

    def point(p):
        angle, speed, rate = p["u"][0], p["s"][2], p["rate"]
        rows = [rate[0] - speed * ca.sin(angle), rate[1] - speed * ca.cos(angle), rate[2] - g * ca.cos(angle)]
        return 0, [r / 10 for r in rows]

    p = transcribe(nlp, nodes, 20, duration, [], states, [(0.0, np.pi, 1.0)], guess, point)
    nlp.rows += p[0]["s"] + [p[-1]["s"][0] - x, p[-1]["s"][1] - y]
    nlp.cost += duration
    return nlp


def cart_pole(nodes, intervals):
    m1, m2, l, g, d, T = 1.0, 0.3, 0.5, 9.81, 1.0, 2.0
    nlp = Nlp()
    axes = [
        {"q": (-2.0, 2.0, 1.0), "v": (-INF, INF, 3.0), "a": (-INF, INF, 10.0)},
        {"q": (-INF, INF, 3.0), "v": (-INF, INF, 6.0), "a": (-INF, INF, 30.0)},
    ]
    guess = lambda share: {
        "q": [d * share, np.pi * share], "v": [d / T, np.pi / T], "a": [0.0, 0.0], "s": [], "rate": [], "u": [0.0],
    }

    def point(p):
        (_, q), (_, v), (ax, aq), u = p["q"], p["v"], p["a"], p["u"][0]
        cart = (m1 + m2) * ax + m2 * l * ca.cos(q) * aq - m2 * l * ca.sin(q) * v * v - u
        pole = l * aq + ca.cos(q) * ax + g * ca.sin(q)
        return u * u, [cart / 10, pole / 10]

    p = transcribe(nlp, nodes, intervals, T, axes, [], [(-20.0, 20.0, 10.0)], guess, point)
    nlp.rows += p[0]["q"] + p[0]["v"] + [p[-1]["q"][0] - d, p[-1]["q"][1] - np.pi] + p[-1]["v"]
    return nlp


def walker(name, nodes):
    import five_link  # which builds on this file

    return five_link.build(five_link.CASES[name], nodes, 25)


BUILD = {
    "double-integrator": double_integrator,
    "brachistochrone": brachistochrone,
    "cart-pole-25": lambda nodes: cart_pole(nodes, 25),
    "cart-pole-100": lambda nodes: cart_pole(nodes, 100),
    "five-link": lambda nodes: walker("published", nodes),
    "five-link-held": lambda nodes: walker("held", nodes),
}


def main():
    command = ["cargo", "run", "--release", "--quiet", "-p", "trajectory", "--example", "library"]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    header = f"{'problem':<18} {'scheme':<16} {'n':>5} {'ours':>8} {'s':>8} {'it':>4} {'IPOPT s':>8} {'it':>4} {'ratio':>6} {'cost differs':>13}"
    print(header)
    ours_total = theirs_total = 0.0
    disagree = 0
    for text in lines:
        ours = json.loads(text)
        theirs = BUILD[ours["problem"]](SCHEMES[ours["scheme"]]).solve()
        gap = abs(ours["cost"] - theirs["cost"]) / max(1.0, abs(theirs["cost"]))
        disagree += gap > 1e-6
        ours_total += ours["seconds"]
        theirs_total += theirs["seconds"]
        print(
            f"{ours['problem']:<18} {ours['scheme']:<16} {ours['variables']:>5} {ours['status']:>8} {ours['seconds']:>8.4f} "
            f"{ours['iterations']:>4} {theirs['seconds']:>8.4f} {theirs['iterations']:>4} "
            f"{ours['seconds'] / theirs['seconds']:>6.2f} {gap:>13.1e}"
        )
    print(f"total {ours_total:.3f} s, IPOPT {theirs_total:.3f} s, ratio {ours_total / theirs_total:.2f}; {disagree} costs differ")
    return 1 if disagree else 0


if __name__ == "__main__":
    sys.exit(main())
