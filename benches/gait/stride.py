"""The gait problem of crates/biped, written a second time with CasADi.

An independent path to the same numbers: the dynamics come from the Lagrangian by automatic
differentiation (the Rust crate sums virtual work), the programme is solved by IPOPT. Needs
`pip install casadi`; nothing in the build depends on it.

Transcription (the same as in Rust): order front stance, flight, rear stance, flight; two-stage Radau IIA.
With h = T_p / N_p the variables are scaled by time, w = h v and b = h^2 a, so that all defects
are linear; the dynamics are multiplied by h^2. The intervals of a compliant stance are short where the foot
strikes (`passed`), and past its first fifth the loss factor is at most LATE_LOSS.
"""

import casadi as ca
import numpy as np

M0, M1, M2, I0, I1, I2 = 7.5, 2.0, 0.28, 0.1, 0.016, 0.01
LC1, LC2, L0, L1, L2 = 0.05, 0.05, 0.6, 0.3, 0.3
LIMIT, GRAVITY = 35.0, 9.81
A = np.array([[5 / 12, -1 / 12], [3 / 4, 1 / 4]])
B = np.array([3 / 4, 1 / 4])
STANCE = [0, None, 1, None]
RATE_LIMIT = 60.0
RATE_WEIGHT = 1e-6
STRIKE, LATE_LOSS = 0.2, 2.0


def along(angle):
    return ca.vertcat(ca.sin(angle), -ca.cos(angle))


def points(q):
    """Hip, knee, foot of both legs."""
    legs = []
    axis = ca.vertcat(ca.cos(q[2]), ca.sin(q[2]))
    for side, i in ((1, 3), (-1, 5)):
        hip = q[0:2] + side * L0 / 2 * axis
        thigh, shank = along(q[2] + q[i]), along(q[2] + q[i] + q[i + 1])
        knee = hip + L1 * thigh
        legs.append((hip, knee, knee + L2 * shank, hip + LC1 * thigh, knee + LC2 * shank))
    return legs


def dynamics():
    """M a + C + G as a CasADi function, from the energies."""
    q, v, a = ca.SX.sym("q", 7), ca.SX.sym("v", 7), ca.SX.sym("a", 7)
    kinetic = 0.5 * M0 * ca.sumsqr(v[0:2]) + 0.5 * I0 * v[2] ** 2
    potential = M0 * GRAVITY * q[1]
    for i, leg in zip((3, 5), points(q)):
        for mass, inertia, centre, rate in (
            (M1, I1, leg[3], v[2] + v[i]),
            (M2, I2, leg[4], v[2] + v[i] + v[i + 1]),
        ):
            kinetic += 0.5 * mass * ca.sumsqr(ca.jtimes(centre, q, v)) + 0.5 * inertia * rate**2
            potential += mass * GRAVITY * centre[1]
    momentum = ca.gradient(kinetic, v)
    force = ca.jtimes(momentum, q, v) + ca.jtimes(momentum, v, a) - ca.gradient(kinetic - potential, q)
    return ca.Function("dynamics", [q, v, a], [force])


DYNAMICS = dynamics()


def friction(mu_f, mu_r, slip_scale, sliding):
    u = -sliding / slip_scale
    s = u / ca.sqrt(1 + u**2)
    return ((mu_f - mu_r) * s**2 + (mu_f + mu_r) * s) / 2


def point_function(stance, rigid):
    """Rows and cost of one collocation point in phase-scaled variables."""
    q, w, b, u, h = ca.SX.sym("q", 7), ca.SX.sym("w", 7), ca.SX.sym("b", 7), ca.SX.sym("u", 4), ca.SX.sym("h")
    force = ca.SX.sym("F", 2)
    par = ca.SX.sym("p", 5)  # k, c, slip, mu_f, mu_r
    v, a = w / h, b / h**2
    legs = points(q)
    res = DYNAMICS(q, v, a) - ca.vertcat(0, 0, 0, u)
    equal, inequal = [], []
    if stance is not None:
        foot = legs[stance][2]
        jac = ca.jacobian(foot, q)
        speed = jac @ v
        if rigid:
            f = force
            equal.append(speed)
            inequal += [par[3] * f[1] - f[0], f[0] + par[4] * f[1], f[1]]
        else:
            loss = 1 - 1.5 * par[1] * speed[1]
            fn = par[0] * (foot[1] ** 2 + 1e-8) ** 0.75 * loss
            f = ca.vertcat(friction(par[3], par[4], par[2], speed[0]) * fn, fn)
            inequal.append(loss)
            sinking = LATE_LOSS - loss
        res -= jac.T @ f
    else:
        f = ca.SX.zeros(2)
    if stance is None or rigid:
        sinking = ca.SX.zeros(0)
    heights = ca.vertcat(legs[0][2][1], legs[1][2][1], legs[0][1][1], legs[1][1][1])
    out = ca.vertcat(*([h**2 * res] + equal))
    args = [q, w, b, u, h] + ([force] if rigid and stance is not None else []) + [par]
    return ca.Function("point", args, [out, ca.vertcat(*inequal) if inequal else ca.SX.zeros(0), heights, f, sinking])


def passed(u, graded):
    """Part of a phase's time that has passed with a part u of its intervals."""
    return u * (0.2 + 0.8 * u) if graded else u


class Stride:
    """Variables, constraints and solver of one kind of stride."""

    def __init__(self, rigid=False, options=None, mesh=(8, 5), longest_stance_s=0.1, rate_limit=RATE_LIMIT,
                 hip_deg=(-110, 70), foot_depth_m=0.05):
        self.rigid = rigid
        self.intervals = [mesh[p % 2] for p in range(4)]
        self.graded = [STANCE[p] is not None and not rigid for p in range(4)]
        x, lower, upper, scale = [], [], [], []
        g, gl, gu = [], [], []
        self.names = {}

        def var(name, n, lo, up, sc):
            s = ca.MX.sym(name, n)
            self.names[name] = (len(lower), n)
            x.append(s)
            lower.extend(np.broadcast_to(lo, n))
            upper.extend(np.broadcast_to(up, n))
            scale.extend(np.broadcast_to(sc, n))
            return s

        def con(expr, lo=0.0, up=0.0):
            n = expr.numel()
            if n == 0:
                return
            g.append(ca.vec(expr))
            gl.extend(np.broadcast_to(lo, n))
            gu.extend(np.broadcast_to(up, n))

        inf = np.inf
        deg = np.pi / 180
        ql = np.array([-inf, -inf, -25 * deg, hip_deg[0] * deg, 10 * deg, hip_deg[0] * deg, 10 * deg])
        qu = np.array([inf, inf, 25 * deg, hip_deg[1] * deg, 150 * deg, hip_deg[1] * deg, 150 * deg])
        par = ca.MX.sym("par", 5)
        weight, aim = ca.MX.sym("weight"), ca.MX.sym("aim")
        T = [var(f"T{p}", 1, 0.02 if STANCE[p] is not None else 0.01, longest_stance_s if STANCE[p] is not None else 0.1, 0.05) for p in range(4)]
        period, speed = var("T", 1, 0.05, 2.0, 0.2), var("V", 1, -5, 40, 5.0)
        share = [var(f"f{p}", 1, 0.0, 1.0, 0.25) for p in range(4)]
        con(sum(T) - period)
        for p in range(4):
            con(share[p] * period - T[p])
        q0 = var("q0", 7, np.r_[0.0, np.full(6, -inf)], np.r_[0.0, np.full(6, inf)], 1.0)
        w0 = [var(f"w0_{p}", 7, -inf, inf, 0.05) for p in range(4)]
        cost = weight * (speed - aim) ** 2
        last = (q0, None)
        functions = {s: point_function(s, rigid) for s in (0, None, 1)}
        self.points = []
        for p in range(4):
            n = self.intervals[p]
            h = T[p] / n
            fine = (8, 5)[p % 2] / n
            qs, ws = last[0], w0[p]
            for i in range(n):
                begin, end_of = (passed(j / n, self.graded[p]) for j in (i, i + 1))
                length = end_of - begin
                stage = []
                for s in range(2):
                    tag = f"{p}_{i}_{s}"
                    stage.append(
                        (
                            var("q" + tag, 7, ql, qu, 1.0),
                            var("w" + tag, 7, -inf, inf, 0.05 * fine),
                            var("b" + tag, 7, -inf, inf, 0.01 * fine**2),
                            var("u" + tag, 4, -LIMIT, LIMIT, LIMIT),
                        )
                    )
                    if rigid and STANCE[p] is not None:
                        stage[-1] += (var("F" + tag, 2, -inf, inf, 100.0),)
                for s in range(2):
                    q, w, b, u = stage[s][:4]
                    con(q - qs - n * length * sum(A[s, j] * stage[j][1] for j in range(2)))
                    con(w - ws - n * length * sum(A[s, j] * stage[j][2] for j in range(2)))
                    forces = list(stage[s][4:])
                    rows, inequal, heights, _, sinking = functions[STANCE[p]](q, w, b, u, h, *forces, par)
                    con(rows)
                    con(inequal, 0, inf)
                    if begin + (1 / 3, 1.0)[s] * length > STRIKE:
                        con(sinking, 0, inf)
                    end = i == n - 1 and s == 1
                    # The leg whose foot touches or leaves the ground at the end of this phase.
                    event = [0, 1, 1, 0][p] if end else None
                    for leg in range(2):
                        if leg == event:
                            # Rigid: at lift-off the foot is still where it stood.
                            if not (rigid and STANCE[p] is not None):
                                con(heights[leg])
                        elif leg == STANCE[p]:
                            if not rigid:
                                con(heights[leg], -foot_depth_m, 0)
                        else:
                            con(heights[leg], 0, inf)
                    con(heights[2:4], 0.02, inf)
                    con(w[3:7] - rate_limit * h, -inf, 0)
                    con(w[3:7] + rate_limit * h, 0, inf)
                    joint = w[3:7] / h
                    cost += share[p] * length * B[s] * (ca.sumsqr(u) / LIMIT**2 + RATE_WEIGHT * ca.sumsqr(joint))
                    self.points.append((p, i, s))
                qs, ws = stage[1][0], stage[1][1]
            last = (qs, ws)
            nxt = (p + 1) % 4
            if rigid and STANCE[nxt] is not None:
                # Impact: M (v+ - v-) = J' L, J v+ = 0, L in the cone.
                impulse = var(f"L{p}", 2, -inf, inf, 5.0)
                q, v1, v2, L = ca.SX.sym("q", 7), ca.SX.sym("a", 7), ca.SX.sym("b", 7), ca.SX.sym("L", 2)
                zero = ca.SX.zeros(7)
                jump = DYNAMICS(q, zero, v2 - v1) - DYNAMICS(q, zero, zero)
                jac = ca.jacobian(points(q)[STANCE[nxt]][2], q)
                imp = ca.Function("impact", [q, v1, v2, L], [jump - jac.T @ L, jac @ v2])
                m, f = imp(qs, ws / h, w0[nxt] / (T[nxt] / self.intervals[nxt]), impulse)
                con(m)
                con(f)
                con(ca.vertcat(par[3] * impulse[1] - impulse[0], impulse[0] + par[4] * impulse[1], impulse[1]), 0, inf)
            else:
                con(w0[nxt] * (T[p] / n) - ws * (T[nxt] / self.intervals[nxt]))
        con(speed * period - qs[0])
        con(qs[1:] - q0[1:])
        self.lower, self.upper, self.scale = map(np.array, (lower, upper, scale))
        self.gl, self.gu = np.array(gl), np.array(gu)
        X = ca.vertcat(*x)
        P = ca.vertcat(par, weight, aim)
        # Scaled variables: x = scale * z.
        z = ca.MX.sym("z", X.numel())
        fun = ca.Function("nlp", [X, P], [cost, ca.vertcat(*g)])
        f, gg = fun(self.scale * z, P)
        opts = {"ipopt.print_level": 0, "print_time": 0, "ipopt.max_iter": 1500, "ipopt.tol": 1e-8,
                "ipopt.mu_strategy": "adaptive", "ipopt.sb": "yes"}
        opts.update(options or {})
        self.fun = fun
        self.solver = ca.nlpsol("s", "ipopt", {"x": z, "p": P, "f": f, "g": gg}, opts)

    def get(self, x, name):
        i, n = self.names[name]
        return x[i : i + n]

    def order(self):
        """Names in the order of the Rust crate's vector of variables."""
        names = [f"T{p}" for p in range(4)] + [f"f{p}" for p in range(4)] + ["T", "V", "q0"]
        names += [f"w0_{p}" for p in range(4)]
        for p, i, s in self.points:
            kinds = "qwbu" + ("F" if self.rigid and STANCE[p] is not None else "")
            names += [f"{kind}{p}_{i}_{s}" for kind in kinds]
        return names + (["L1", "L3"] if self.rigid else [])

    def to_rust(self, x):
        return np.concatenate([self.get(x, name) for name in self.order()])

    def from_rust(self, y):
        x, at = np.zeros(len(self.lower)), 0
        for name in self.order():
            i, n = self.names[name]
            x[i : i + n] = y[at : at + n]
            at += n
        assert at == len(y) == len(x)
        return x

    def read_from(self, other, x):
        """A stride of another mesh read on this one: the collocation's own polynomials at the new points."""
        y = np.zeros(len(self.lower))

        def put(name, value):
            i, n = self.names[name]
            y[i : i + n] = value

        for name in [f"T{p}" for p in range(4)] + [f"f{p}" for p in range(4)] + ["T", "V", "q0"]:
            put(name, other.get(x, name))
        for p in range(4):
            n, m = other.intervals[p], self.intervals[p]
            put(f"w0_{p}", other.get(x, f"w0_{p}") * n / m)
            for i in range(m):
                for s, c in enumerate((1 / 3, 1.0)):
                    here = [passed(k / m, self.graded[p]) for k in (i, i + 1)]
                    ends = [passed(k / n, other.graded[p]) for k in range(n + 1)]
                    now = here[0] + c * (here[1] - here[0])
                    j = next((k for k in range(n - 1) if now < ends[k + 1] + 1e-12), n - 1)
                    part = (now - ends[j]) / (ends[j + 1] - ends[j])
                    relative = n * (ends[j + 1] - ends[j])
                    before = f"{p}_{j - 1}_1" if j else f"{p - 1}_{other.intervals[p - 1] - 1}_1"
                    q0 = other.get(x, "q" + before) if p or j else other.get(x, "q0")
                    w0 = other.get(x, "w" + before) if j else other.get(x, f"w0_{p}")
                    at = {kind: [other.get(x, f"{kind}{p}_{j}_{stage}") for stage in (0, 1)] for kind in "wbu"}
                    slope = {kind: (two - one) / (2 / 3) for kind, (one, two) in at.items()}
                    line = {kind: at[kind][0] + (part - 1 / 3) * slope[kind] for kind in "wbu"}
                    area = {kind: (at[kind][0] - slope[kind] / 3) * part + slope[kind] * part**2 / 2 for kind in "wb"}
                    tag = f"{p}_{i}_{s}"
                    put("q" + tag, q0 + relative * area["w"])
                    put("w" + tag, (w0 + relative * area["b"]) * n / m)
                    put("b" + tag, line["b"] * (n / m) ** 2)
                    put("u" + tag, line["u"])
        return y

    def guess(self, speed=4.0, period=0.3, amplitude=0.4):
        x = np.zeros(len(self.lower))

        def put(name, value):
            i, n = self.names[name]
            x[i : i + n] = value

        T = np.array([0.3, 0.2, 0.3, 0.2]) * period
        for p in range(4):
            put(f"T{p}", T[p])
            put(f"f{p}", T[p] / period)
        put("T", period)
        put("V", speed)
        deg = np.pi / 180

        def state(t):
            w = 2 * np.pi / period
            q, v = np.zeros(7), np.zeros(7)
            q[:3] = speed * t, 0.42, 0.0
            v[0] = speed
            for leg, i, mid in ((0, 3, T[0] / 2), (1, 5, T[0] + T[1] + T[2] / 2)):
                # The thigh swings back through the middle of its stance.
                q[i] = -45 * deg - amplitude * np.sin(w * (t - mid))
                v[i] = -amplitude * w * np.cos(w * (t - mid))
                q[i + 1] = (90 * deg) + 0.35 * (1 - np.cos(w * (t - mid)))
                v[i + 1] = 0.35 * w * np.sin(w * (t - mid))
            return q, v

        put("q0", state(0)[0])
        start = np.r_[0, np.cumsum(T)]
        for p in range(4):
            h = T[p] / self.intervals[p]
            put(f"w0_{p}", h * state(start[p])[1])
            for i in range(self.intervals[p]):
                for s, c in enumerate((1 / 3, 1.0)):
                    begin, end_of = (passed(k / self.intervals[p], self.graded[p]) for k in (i, i + 1))
                    q, v = state(start[p] + T[p] * (begin + c * (end_of - begin)))
                    put(f"q{p}_{i}_{s}", q)
                    put(f"w{p}_{i}_{s}", h * v)
                    if self.rigid and STANCE[p] is not None:
                        put(f"F{p}_{i}_{s}", [0.0, 200.0])
        return x

    def solve(self, x, k=2e5, c=1.0, slip=0.1, mu=(0.9049, 0.4314), weight=1.0, aim=20.0):
        r = self.solver(x0=x / self.scale, p=[k, c, slip, *mu, weight, aim], lbx=self.lower / self.scale,
                        ubx=self.upper / self.scale, lbg=self.gl, ubg=self.gu)
        st = self.solver.stats()
        xs = np.array(r["x"]).ravel() * self.scale
        return xs, dict(ok=st["success"], status=st["return_status"], iterations=st["iter_count"], cost=float(r["f"]),
                        speed=float(self.get(xs, "V")[0]), seconds=st.get("t_proc_total", 0.0), x=xs)
